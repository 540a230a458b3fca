#include "plica/airflow/pressure_course.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "plica/core/error.hpp"

namespace plica {

double PressureCourse::at(double t) const {
  const auto later = std::upper_bound(time.begin(), time.end(), t);
  if (later == time.begin()) return pressure.front();
  if (later == time.end()) return pressure.back();
  const auto k = static_cast<std::size_t>(later - time.begin());
  const double share = (t - time[k - 1]) / (time[k] - time[k - 1]);
  return pressure[k - 1] + share * (pressure[k] - pressure[k - 1]);
}

double PressureCourse::greatest() const { return *std::max_element(pressure.begin(), pressure.end()); }

void PressureCourse::validate() const {
  const char* const where = "PressureCourse";
  if (time.size() < 2) throw InvalidInput(where, "number of times", static_cast<double>(time.size()), "", ">= 2");
  if (pressure.size() != time.size())
    throw InvalidInput(where, "number of pressures", static_cast<double>(pressure.size()), "",
                       "that of times, " + std::to_string(time.size()));
  for (std::size_t k = 0; k < time.size(); ++k) {
    const std::string at = "[" + std::to_string(k) + "]";
    const double before = k > 0 ? time[k - 1] : 0.0;
    if (!std::isfinite(time[k]) || (k > 0 ? time[k] <= before : time[k] < 0))
      throw InvalidInput(where, "time" + at, time[k], "s",
                         k > 0 ? "> the one before, " + number_text(before) + " s" : ">= 0", "Is the unit right?");
    if (!std::isfinite(pressure[k]) || pressure[k] < 0)
      throw InvalidInput(where, "pressure" + at, pressure[k], "Pa", ">= 0 and finite", "Is the unit right?");
  }
  if (!(greatest() > 0)) throw InvalidInput(where, "greatest pressure", greatest(), "Pa", "> 0");
}

}  // namespace plica

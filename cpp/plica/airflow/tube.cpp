#include "plica/airflow/tube.hpp"

#include <cmath>
#include <string>

#include "plica/core/error.hpp"

namespace plica {

namespace {

bool positive(double value) { return value > 0 && std::isfinite(value); }
bool not_negative(double value) { return value >= 0 && std::isfinite(value); }

}  // namespace

void Tube::validate(const char* where) const {
  const auto check = [&](bool holds, const std::string& name, double value, const char* unit,
                         const char* relation) {
    if (!holds) throw InvalidInput(where, name, value, unit, relation, "Is the unit right?");
  };
  if (length.empty()) throw InvalidInput(where, "parts of the tube", 0, "", "1 or more");
  if (length.size() != area.size())
    throw InvalidInput(where, "number of areas", static_cast<double>(area.size()), "",
                       "that of lengths, " + std::to_string(length.size()));
  for (std::size_t i = 0; i < length.size(); ++i) {
    const std::string part = " of part " + std::to_string(i);
    check(length[i] > 0 && length[i] <= 10, "length" + part, length[i], "m", "in (0, 10]");
    check(positive(area[i]), "area" + part, area[i], "m^2", "> 0 and finite");
  }
  check(not_negative(friction_frequency), "friction_frequency", friction_frequency, "Hz", ">= 0 and finite");
  if (wall) {
    check(positive(wall->mass), "mass of the wall", wall->mass, "kg/m^2", "> 0 and finite");
    check(not_negative(wall->resistance), "resistance of the wall", wall->resistance, "Pa s/m", ">= 0 and finite");
    check(positive(wall->stiffness), "stiffness of the wall", wall->stiffness, "Pa/m", "> 0 and finite");
  }
  if (const auto* supply = std::get_if<PressureSupply>(&end)) {
    check(supply->reflection >= 0 && supply->reflection <= 1, "reflection", supply->reflection, "", "in [0, 1]");
    check(not_negative(supply->volume), "volume", supply->volume, "m^3", ">= 0 and finite");
    if (supply->volume > 0 && supply->reflection == 1)
      throw InvalidInput(where, "volume", supply->volume, "m^3", "0 with a reflection of 1",
                         "Nothing is behind a pressure that is held.");
  }
  if (const auto* supply = std::get_if<FlowSupply>(&end)) {
    check(not_negative(supply->volume), "volume", supply->volume, "m^3", ">= 0 and finite");
    check(not_negative(supply->flow), "flow", supply->flow, "m^3/s", ">= 0 and finite");
  }
}

void Tubes::validate() const {
  if (!(sound_speed > 0) || !std::isfinite(sound_speed))
    throw InvalidInput("Airflow", "sound_speed", sound_speed, "m/s", "> 0 and finite", "Is the unit right?");
  if (trachea) trachea->validate("Trachea");
  if (tract) tract->validate("Tract");
  if (trachea && std::holds_alternative<Radiation>(trachea->end))
    throw InvalidInput("Trachea: its end is open; must be a supply of pressure or flow.");
  if (const auto* supply = trachea ? std::get_if<FlowSupply>(&trachea->end) : nullptr; supply && supply->flow == 0)
    throw InvalidInput("Trachea", "flow", 0.0, "m^3/s", "> 0", "Nothing else drives the airflow.");
  if (const auto* supply = tract ? std::get_if<FlowSupply>(&tract->end) : nullptr; supply && supply->flow != 0)
    throw InvalidInput("Tract", "flow", supply->flow, "m^3/s", "0", "Its end is not driven.");
}

}  // namespace plica

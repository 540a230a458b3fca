#pragma once
#include <vector>

namespace plica {

/// A pressure over time: straight lines between points, that of the first before them, of the last after them.
struct PressureCourse {
  std::vector<double> time;      // s, >= 0, rising: two or more
  std::vector<double> pressure;  // Pa, >= 0, one of them > 0
  double at(double t) const;
  double greatest() const;  // Pa
  void validate() const;    // throws InvalidInput
};

}  // namespace plica

#include "plica/core/error.hpp"

#include <cstdio>

#include "plica/core/types.hpp"

namespace plica {

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string place_text(const Vector3& x) {
  return "(" + number_text(x[0]) + ", " + number_text(x[1]) + ", " + number_text(x[2]) + ") m";
}

InvalidInput::InvalidInput(const std::string& where, const std::string& name, double value,
                           const std::string& unit, const std::string& relation, const std::string& hint)
    : std::invalid_argument(where + ": " + name + " = " + number_text(value) + (unit.empty() ? "" : " " + unit) +
                            "; must be " + relation + "." + (hint.empty() ? "" : " " + hint)) {}

}  // namespace plica

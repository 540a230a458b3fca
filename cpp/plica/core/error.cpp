#include "plica/core/error.hpp"

#include <cstdio>

namespace plica {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string place(const Vector3& x) {
  return "(" + number(x[0]) + ", " + number(x[1]) + ", " + number(x[2]) + ") m";
}

InvalidInput::InvalidInput(const std::string& where, const std::string& name, double value,
                           const std::string& unit, const std::string& relation, const std::string& hint)
    : std::invalid_argument(where + ": " + name + " = " + number(value) + (unit.empty() ? "" : " " + unit) +
                            "; must be " + relation + "." + (hint.empty() ? "" : " " + hint)) {}

}  // namespace plica

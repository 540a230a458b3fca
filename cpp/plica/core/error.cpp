#include "plica/core/error.hpp"

#include <cstdio>

namespace plica {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

InvalidInput::InvalidInput(const std::string& where, const std::string& name, double value,
                           const std::string& unit, const std::string& relation, const std::string& hint)
    : std::invalid_argument(where + ": " + name + " = " + number(value) + (unit.empty() ? "" : " " + unit) +
                            "; must be " + relation + "." + (hint.empty() ? "" : " " + hint)) {}

}  // namespace plica

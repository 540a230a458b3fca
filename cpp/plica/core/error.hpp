#pragma once
#include <stdexcept>
#include <string>

namespace plica {

/// What a caller handed in cannot be used. Its text reads
/// `Where: name = value unit; must be relation. Hint.`
class InvalidInput : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
  InvalidInput(const std::string& where, const std::string& name, double value, const std::string& unit,
               const std::string& relation, const std::string& hint = "");
};

/// A computation ended without a meaningful state; its text says what, when, and what to try.
class SolveFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The shortest text that reads back as the same number to six digits, e.g. "1e-05", "800".
std::string number_text(double value);

}  // namespace plica

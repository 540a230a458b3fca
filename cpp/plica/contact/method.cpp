#include "plica/contact/method.hpp"

#include <algorithm>
#include <cmath>

#include "plica/contact/mortar.hpp"
#include "plica/contact/node_pairs.hpp"
#include "plica/core/error.hpp"

namespace plica {

namespace {

/// Whether a force is that of a constraint which is no more, so that nothing tells whether it should be. Keys
/// ascend.
bool presses_nothing(const Contacts& last, const std::vector<Constraint>& constraints) {
  const auto less = [](const Constraint& constraint, std::int32_t key) { return constraint.key < key; };
  const std::vector<std::int32_t> pressing = last.closed().first;
  return std::any_of(pressing.begin(), pressing.end(), [&](std::int32_t key) {
    const auto at = std::lower_bound(constraints.begin(), constraints.end(), key, less);
    return at == constraints.end() || at->key != key;
  });
}

}  // namespace

std::unique_ptr<ConstraintKind> ContactMethod::kind(Detector& detector, const FaceMethod& faces) const {
  if (const auto* mortar = std::get_if<Mortar>(&faces))
    return mortar_averages(detector, mortar->first, mortar->second);
  return node_pairs(detector);
}

double ContactMethod::violation(const Constraint& constraint, double force, const Points& x) const {
  const double off = residual(constraint, force, x);
  return force == 0.0 ? std::max(0.0, -off) : std::abs(off);
}

bool ContactMethod::settled(Contacts& last, const std::vector<Constraint>& constraints, const Points& x,
                            double tolerance) {
  last.gap_error = 0;
  for (const Constraint& constraint : constraints)
    last.gap_error = std::max(last.gap_error, violation(constraint, last.force_of(constraint.key), x));
  return last.gap_error <= tolerance && !presses_nothing(last, constraints);
}

std::unique_ptr<ContactMethod> contact_method(const Enforcement& enforcement) {
  return std::visit([](const auto& options) { return contact_method(options); }, enforcement);
}

void require_positive(const char* name, double value, const char* unit) {
  if (!(value > 0) || !std::isfinite(value)) throw InvalidInput("Contact", name, value, unit, "> 0 and finite");
}

}  // namespace plica

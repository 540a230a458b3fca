#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "plica/contact/method.hpp"
#include "plica/core/error.hpp"

namespace plica {

namespace {

/// Uzawa's iteration: a pass is an augmentation.
class AugmentedMethod final : public ContactMethod {
 public:
  explicit AugmentedMethod(const Augmented& options) : options_(options) {
    require_positive("stiffness", options_.stiffness, "N/m");
    if (!(options_.growth > 1) || !std::isfinite(options_.growth))
      throw InvalidInput("Contact", "growth", options_.growth, "", "> 1 and finite");
    if (!(options_.reduction > 0 && options_.reduction < 1))
      throw InvalidInput("Contact", "reduction", options_.reduction, "", "in (0, 1)");
    if (options_.max_augmentations < 1)
      throw InvalidInput("Contact", "max_augmentations", options_.max_augmentations, "", ">= 1");
  }

  bool takes_friction() const override { return true; }
  bool exact() const override { return true; }

  std::vector<std::int32_t> begin(const BeforeContact& before) override {
    stiffness_ = options_.stiffness;
    last_error_ = std::numeric_limits<double>::infinity();
    take_up(before.closed, before.force);
    return before.closed;
  }

  void complete(Constraint& constraint, const Detector&) const override {
    constraint.stiffness = stiffness_;
    if (const auto known = multiplier_.find(constraint.key); known != multiplier_.end())
      constraint.multiplier = known->second;
  }

  /// The forces become the next multipliers, and the stiffness is raised where that did too little.
  bool settled(Contacts& last, const std::vector<Constraint>& constraints, const Points& x,
               double tolerance) override {
    const auto [keys, forces] = last.closed();
    take_up(keys, forces);
    double error = 0;
    for (const Constraint& constraint : constraints) {
      const double gap = constraint.gap(x);
      error = std::max(error, multiplier_.count(constraint.key) ? std::abs(gap) : -gap);
    }
    last.gap_error = error;
    last.converged = error <= tolerance;
    if (last.converged || last.augmentations >= options_.max_augmentations) return true;
    if (error > (1 - options_.reduction) * last_error_) stiffness_ *= options_.growth;
    last_error_ = error;
    ++last.augmentations;
    return false;
  }

  bool renews_constraints() const override { return true; }

 private:
  void take_up(const std::vector<std::int32_t>& keys, const Vector& forces) {
    multiplier_.clear();
    for (std::size_t i = 0; i < keys.size(); ++i) multiplier_[keys[i]] = forces[static_cast<std::ptrdiff_t>(i)];
  }

  Augmented options_;
  // Where the step stands.
  double stiffness_ = 0.0;                     // N/m
  std::map<std::int32_t, double> multiplier_;  // N, by key
  double last_error_ = 0.0;                    // m
};

}  // namespace

std::unique_ptr<ContactMethod> contact_method(const Augmented& options) {
  return std::make_unique<AugmentedMethod>(options);
}

}  // namespace plica

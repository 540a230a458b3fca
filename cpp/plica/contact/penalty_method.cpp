#include "plica/contact/method.hpp"
#include "plica/core/error.hpp"

namespace plica {

namespace {

class PenaltyMethod final : public ContactMethod {
 public:
  explicit PenaltyMethod(const Penalty& options) : stiffness_(options.stiffness) {
    require_positive("stiffness", stiffness_, "N/m");
  }

  void complete(Constraint& constraint, const Detector&) const override { constraint.stiffness = stiffness_; }

 private:
  double stiffness_;  // N/m
};

}  // namespace

std::unique_ptr<ContactMethod> contact_method(const Penalty& options) {
  return std::make_unique<PenaltyMethod>(options);
}

}  // namespace plica

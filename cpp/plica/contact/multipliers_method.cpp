#include "plica/contact/method.hpp"

namespace plica {

namespace {

class MultipliersMethod final : public ContactMethod {
 public:
  explicit MultipliersMethod(const Multipliers& options) : options_(options) {}

  bool takes_friction() const override {
    return std::holds_alternative<Condensed>(options_.solver) ||
           std::holds_alternative<Automatic>(options_.solver);
  }
  GapPosition position() const override { return options_.position; }
  bool exact() const override { return true; }

 private:
  ContactSolver own_solver() const override { return options_.solver; }

  Multipliers options_;
};

}  // namespace

std::unique_ptr<ContactMethod> contact_method(const Multipliers& options) {
  return std::make_unique<MultipliersMethod>(options);
}

}  // namespace plica

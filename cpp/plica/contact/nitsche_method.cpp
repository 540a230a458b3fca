#include "plica/contact/method.hpp"
#include "plica/core/error.hpp"

namespace plica {

namespace {

class NitscheMethod final : public ContactMethod {
 public:
  explicit NitscheMethod(const Nitsche& options) : factor_(options.factor) {
    require_positive("factor", factor_, "");
  }

  bool needs_stress() const override { return true; }

  std::unique_ptr<ConstraintKind> kind(Detector& detector, const FaceMethod& faces) const override {
    if (std::holds_alternative<Mortar>(faces))
      throw InvalidInput(
          "Contact: faces = \"mortar\"; must come with multipliers, augmented multipliers or the penalty: "
          "Nitsche's method takes the tissue's stress at nodes.");
    return ContactMethod::kind(detector, faces);
  }

  std::vector<std::int32_t> begin(const BeforeContact& before) override {
    stress_ = before.stress;
    return {};
  }

  void complete(Constraint& constraint, const Detector& detector) const override {
    const std::int32_t slave = constraint.slave;
    const ContactSurface& own = detector.first().contains(slave) ? detector.first() : detector.second();
    constraint.gamma = factor_ * stress_->stiffness(slave, constraint.normal, detector.mean_edge());
    constraint.stiffness = constraint.gamma * own.tributary_area(slave);
  }

  /// Adds the tissue's normal stress over gamma to the row's gap.
  void complete(Row& row, const Constraint& constraint, const Points& x_free) const override {
    row.free += stress_->at(constraint.slave, constraint.normal, x_free) / constraint.gamma;
    for (const auto& [node, slope] : stress_->slopes(constraint.slave, constraint.normal))
      row.gap.push_back({node, slope / constraint.gamma});
  }

 private:
  /// Its rows are far from symmetric.
  ContactSolver own_solver() const override { return Condensed{}; }

  double residual(const Constraint& constraint, double p, const Points& x) const override {
    return constraint.residual(p, x) + stress_->at(constraint.slave, constraint.normal, x) / constraint.gamma;
  }

  double factor_;
  const NormalStress* stress_ = nullptr;  // of the step
};

}  // namespace

std::unique_ptr<ContactMethod> contact_method(const Nitsche& options) {
  return std::make_unique<NitscheMethod>(options);
}

}  // namespace plica

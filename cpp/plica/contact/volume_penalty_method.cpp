#include "plica/contact/method.hpp"
#include "plica/contact/node_pairs.hpp"
#include "plica/core/error.hpp"

namespace plica {

namespace {

class VolumePenaltyMethod final : public ContactMethod {
 public:
  explicit VolumePenaltyMethod(const VolumePenalty& options) : kappa_(options.kappa) {
    require_positive("kappa", kappa_, "N/m^3");
  }

  std::unique_ptr<ConstraintKind> kind(Detector& detector, const FaceMethod& faces) const override {
    if (std::holds_alternative<Mortar>(faces))
      throw InvalidInput(
          "Contact: faces = \"mortar\"; must come with multipliers, augmented multipliers or the penalty: "
          "the volume penalty has its own faces, those of the airway's tetrahedra.");
    return volume_pairs(detector, kappa_);  // which bring their stiffness
  }

 private:
  double kappa_;  // N/m^3
};

}  // namespace

std::unique_ptr<ContactMethod> contact_method(const VolumePenalty& options) {
  return std::make_unique<VolumePenaltyMethod>(options);
}

}  // namespace plica

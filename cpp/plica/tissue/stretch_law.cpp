#include "plica/tissue/stretch_law.hpp"

#include <cmath>

namespace plica {
namespace {

Matrix3 green_strain(const Matrix3& F) { return 0.5 * (F.transpose() * F - Matrix3::Identity()); }

Vector6 engineering(const Matrix3& E) {
  Vector6 strain;
  strain << E(0, 0), E(1, 1), E(2, 2), 2 * E(0, 1), 2 * E(1, 2), 2 * E(2, 0);
  return strain;
}

}  // namespace

StretchLaw::StretchLaw(const Material& material)
    : elasticity_(elasticity_matrix(material)),
      fibre_(fibre_of(material).normalized()),
      stiffening_(material.stiffening),
      active_(material.active_stress) {
  const Vector3& a = fibre_;
  dyad_ << a.x() * a.x(), a.y() * a.y(), a.z() * a.z(), a.x() * a.y(), a.y() * a.z(), a.z() * a.x();
  if (const auto* law = std::get_if<TransverselyIsotropic>(&material.elasticity)) along_ = law->E_fibre;
}

StretchLaw::Response StretchLaw::at(const Matrix3& F) const {
  const Matrix3 E = green_strain(F);
  Vector6 T = elasticity_ * engineering(E);
  Response response{Matrix3(), elasticity_};
  const double along = fibre_.dot(E * fibre_);
  double tension = 0.0, stiffness = 0.0;
  if (stiffening_ > 0 && along > 0) {
    const double square = 4 * stiffening_ * along * along, more = std::expm1(square);
    tension = along_ * along * more;
    stiffness = along_ * (more + 2 * square * (more + 1));
  }
  if (active_ != 0) {
    const double stretch = std::sqrt(1 + 2 * along);
    tension += active_ / stretch;
    stiffness -= active_ / (stretch * stretch * stretch);
  }
  if (tension != 0 || stiffness != 0) {
    T += tension * dyad_;
    response.slope += stiffness * (dyad_ * dyad_.transpose());
  }
  response.stress << T[0], T[3], T[5], T[3], T[1], T[4], T[5], T[4], T[2];
  return response;
}

double StretchLaw::energy(const Matrix3& F) const {
  const Matrix3 E = green_strain(F);
  const Vector6 strain = engineering(E);
  double energy = 0.5 * strain.dot(elasticity_ * strain);
  const double along = fibre_.dot(E * fibre_);
  if (stiffening_ > 0 && along > 0) {
    const double square = 4 * stiffening_ * along * along;
    energy += along_ * (std::expm1(square) / (8 * stiffening_) - 0.5 * along * along);
  }
  if (active_ != 0) energy += active_ * (std::sqrt(1 + 2 * along) - 1);
  return energy;
}

}  // namespace plica

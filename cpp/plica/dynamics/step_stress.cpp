#include "plica/dynamics/step_stress.hpp"

namespace plica {

double StepStress::at(std::int32_t node, const Vector3& n, const Points& x) const {
  Vector6 stress = Vector6::Zero();
  for (const auto& [other, elastic, viscous] : tissue_.at(node)) {
    const std::ptrdiff_t k = 3 * static_cast<std::ptrdiff_t>(other);
    const Vector3 u = (x.row(other) - reference_.row(other)).transpose();
    const Vector3 v = v_predictor_.segment<3>(k) + rate_ * (u - u_predictor_.segment<3>(k));
    stress += elastic * ((1 + alpha_) * u - alpha_ * u_behind_.segment<3>(k));
    stress += viscous * ((1 + alpha_) * v - alpha_ * v_behind_.segment<3>(k));
  }
  return normal_dyad(n).dot(stress);
}

std::vector<NodeVector> StepStress::slopes(std::int32_t node, const Vector3& n) const {
  const Vector6 dyad = normal_dyad(n);
  std::vector<NodeVector> slopes;
  for (const auto& [other, elastic, viscous] : tissue_.at(node))
    slopes.push_back({other, (1 + alpha_) * (elastic + rate_ * viscous).transpose() * dyad});
  return slopes;
}

}  // namespace plica

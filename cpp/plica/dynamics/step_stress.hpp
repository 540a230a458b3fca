#pragma once
#include "plica/contact/normal_stress.hpp"
#include "plica/dynamics/scheme.hpp"
#include "plica/tissue/node_stress.hpp"

namespace plica {

/// The normal stress that balances the contact force in a step: of U = (1+alpha) u_{n+1} - alpha u_n and V
/// likewise, where v_{n+1} = v~ + gamma / (beta h) (u_{n+1} - u~) follows the positions.
class StepStress final : public NormalStress {
 public:
  /// All must outlive it. u_n and v_n as they enter U and V (Step: `behind`); predictors u~ and v~ (3 n) exclude
  /// the unknown acceleration.
  StepStress(const NodeStress& tissue, const Points& reference, const Vector& u_behind, const Vector& v_behind,
             const Vector& u_predictor, const Vector& v_predictor, const SchemeCoefficients& scheme, double h)
      : tissue_(tissue),
        reference_(reference),
        u_behind_(u_behind),
        v_behind_(v_behind),
        u_predictor_(u_predictor),
        v_predictor_(v_predictor),
        alpha_(scheme.alpha),
        rate_(scheme.gamma / (scheme.beta * h)),
        inverse_square_(1.0 / (scheme.beta * h * h)) {}

  double at(std::int32_t node, const Vector3& n, const Points& x) const override;
  std::vector<NodeVector> slopes(std::int32_t node, const Vector3& n) const override;
  double stiffness(std::int32_t node, const Vector3& n, double depth) const override {
    return tissue_.modulus(node, n) / depth + tissue_.density(node) * depth * inverse_square_;
  }

 private:
  const NodeStress& tissue_;
  const Points& reference_;
  const Vector& u_behind_;
  const Vector& v_behind_;
  const Vector& u_predictor_;
  const Vector& v_predictor_;
  double alpha_;
  double rate_;            // 1/s
  double inverse_square_;  // 1/s^2
};

}  // namespace plica

#pragma once
#include "plica/dynamics/coupling.hpp"
#include "plica/dynamics/reduced_contact.hpp"
#include "plica/dynamics/reduced_flow.hpp"
#include "plica/dynamics/state.hpp"

namespace plica {

/// As Step, of the coordinates of a reduced motion: M a + C V + K U = load + contact_force. One product with A^-1,
/// under the load of the first move and without contact; what later moves and contact add is superposed.
class ReducedStep final : public CoupledStep {
 public:
  /// From the state `last`, under scene_load (r) at t_{n+1+alpha}; flow and contact are null where there is none.
  /// All must outlive it.
  ReducedStep(const ModalMotion& motion, const State& last, Vector scene_load, ReducedFlow* flow,
              ReducedContact* contact, const Vector3& origin, StepTimes& times);

  /// Moves it under the scene's load alone.
  void move();
  void move(const Vector& pressure, Instant at) override;
  Vector areas(Instant at) const override;
  bool blocks() const override;
  StepTimes& times() const override { return times_; }

  /// The state that it leads to, its ledger, first signs and depth still those of the last.
  State end();

 private:
  /// From the displacement at t_{n+1} without contact to that with it.
  void touch();
  double inertia() const { return motion_.scheme().beta * motion_.step() * motion_.step(); }
  double weight() const { return 1 + motion_.scheme().alpha; }

  const ModalMotion& motion_;
  const State& last_;
  ReducedFlow* flow_;
  ReducedContact* contact_;
  const Vector3& origin_;
  StepTimes& times_;

  // Fixed within the step, (r).
  Vector displacement_predictor_, velocity_predictor_, elastic_predictor_, viscous_predictor_, inner_force_;
  Vector elastic_behind_, viscous_behind_;
  Vector scene_load_;

  // The current iterate.
  Vector flow_load_;             // Phi^T of the flow's, of the first move
  Vector free_;                  // (r) acceleration under that, without contact
  Vector solved_at_;             // Pa, of the first move; empty before
  Vector load_change_, change_;  // what this move's load and acceleration differ by; empty: by nothing
  Vector end_;                   // (r) displacement at t_{n+1} of this move; extrapolated before the first
};

}  // namespace plica

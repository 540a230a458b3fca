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
  ReducedStep(const ModalMotion& motion, const State& last, Vector scene_load, const ReducedFlow* flow,
              ReducedContact* contact, const Vector3& origin, StepTimes& times);

  /// Moves it under the scene's load alone.
  void move();
  void move(const Vector& pressure, Instant at) override;
  Vector areas(Instant at) const override;
  bool blocks() const override;
  StepTimes& times() const override { return times_; }

  const Contacts& contacts() const { return contacts_; }
  /// Whether its surfaces were so far apart in every move that contact was not looked for.
  bool apart() const { return never_near_; }
  /// The state that it leads to, its ledger, first signs and depth still those of the last.
  State end();
  /// Phi^T of the flow's load.
  const Vector& flow_load() const { return flow_load_; }

 private:
  void solve_free();
  /// Areas and positions of this move without contact.
  void take_positions(const Vector& change);
  void touch();
  /// Whether nothing can touch at these offsets of t_{n+1}, and nothing did before.
  bool apart(const Eigen::VectorXf& offsets) const { return last_.closed.empty() && contact_->apart(offsets); }
  double inertia() const { return motion_.scheme().beta * motion_.step() * motion_.step(); }
  double weight() const { return 1 + motion_.scheme().alpha; }
  /// (1 + alpha) q - alpha q_n
  Vector weighted(const Vector& q) const { return weight() * q - motion_.scheme().alpha * last_.displacement; }

  const ModalMotion& motion_;
  const State& last_;
  const ReducedFlow* flow_;
  ReducedContact* contact_;
  const Vector3& origin_;
  StepTimes& times_;

  // Fixed within the step, (r).
  Vector displacement_predictor_, velocity_predictor_, elastic_predictor_, viscous_predictor_, inner_force_;
  Vector elastic_behind_, viscous_behind_;
  Vector scene_load_;

  // The current iterate.
  Vector flow_load_;
  Vector free_, free_end_;       // (r), of the load of the first move without contact: acceleration, displacement
  Vector solved_at_, pressure_;  // Pa, of the first move and of this one
  Points x_before_;              // (m, 3) m, of the contact, where it is near
  bool near_ = true;             // whether surfaces may touch, or have, and widths change their sign
  bool never_near_ = false;
  Vector free_areas_, areas_;     // (s) m^2, weighted, where they are not near; of free_, and of this move
  Vector free_widths_, widths_;   // (s * stations) m, weighted, where they are
  Eigen::VectorXf free_offsets_;  // m, at t_{n+1}
  Points x_free_, x_;             // (m, 3) m, at t_{n+1}, where they are near; of free_, and of this move
  Contacts contacts_;
  Vector contact_nodal_;  // (3 m) N
  Vector contact_load_;   // Phi^T of it
  Vector contact_acceleration_;
};

}  // namespace plica

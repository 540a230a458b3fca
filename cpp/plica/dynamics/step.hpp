#pragma once
#include "plica/dynamics/motion.hpp"
#include "plica/dynamics/nodal_step.hpp"
#include "plica/dynamics/record.hpp"
#include "plica/dynamics/tissue_balance.hpp"

namespace plica {

class SceneContact;
class SceneFlow;
class PressureResponse;

/// One step in the making, positions from the motion's origin: M a + C V + K U = load + contact_force with U =
/// (1+alpha) u_{n+1} - alpha u_n, V likewise, where u_n and v_n are `displacement_behind` and `velocity_behind`:
/// in the first step U_0 and V_0.
///
/// Positions are those of the nodes that are `seen`, by the flow or by contact. They follow from one solve, under
/// the load of the first move and without contact; what later moves and contact add to these is superposed as far
/// as its response is known (SceneFlow::response, Collision::add_response), and solved for otherwise.
///
/// Tissue at finite strain has its ExcessForce r on the left side; a move is one under an r that is known, and
/// settle() says whether it is that of where the move led.
class Step final : public NodalStep {
 public:
  /// From the state `last`, under scene_load (3 n) N at t_{n+1+alpha}; flow and contact are null where there is
  /// none. All must outlive it.
  Step(const Motion& motion, const State& last, Vector scene_load, const Indices& seen, const SceneFlow* flow,
       SceneContact* contact, StepTimes& times);

  // What a coupling needs of it.
  const Points& x_previous() const override { return x_previous_; }
  /// (n, 3) m at t_{n+1+alpha}: extrapolated, (1 + alpha) (u + h v + h^2 a / 2) - alpha u at reference positions,
  /// until it is moved; then of where it has been moved, (1 + alpha) x - alpha x_previous.
  const Points& weighted_positions() const { return weighted_; }
  void move() override;
  void move(const AirwayPressure& pressure, Instant at) override;
  void move_again() override;
  Vector areas(Instant at) const override;
  AirwayExpansion expansion(Instant at) const override;
  bool blocks() const override;
  StepTimes& times() const override { return times_; }

  // What contact needs of it.
  const Motion& motion() const { return motion_; }
  const State& last() const { return last_; }
  const Vector& displacement_predictor() const { return displacement_predictor_; }
  const Vector& velocity_predictor() const { return velocity_predictor_; }
  const Vector& displacement_behind() const { return last_.step == 0 ? first_displacement_ : last_.displacement; }
  const Vector& velocity_behind() const { return last_.step == 0 ? first_velocity_ : last_.velocity; }

  /// (n, 3) m at t_{n+1} of where it has been moved.
  const Points& x() const { return x_; }
  const Contacts& contacts() const override { return contacts_; }
  int iterations() const override { return iterations_; }

  bool settle() override;
  bool retreat() override;
  int evaluations() const override { return tissue_ ? tissue_->evaluations() : 0; }
  void complete() override;
  State end() override;
  Vector take_image() override { return std::move(image_); }

 private:
  void predict();
  void begin_balance();
  void solve_anew();  // in the next move, from where this one has led
  /// U and V under an acceleration.
  void weigh(const Vector& a, Vector& U, Vector& V) const;
  /// load_ under pressure_, for what is solved; where a response moves the positions this is left to the end.
  void take_load(Instant instant);
  /// Solves for the positions under load_, without contact.
  void solve_free();
  const Points& at(Instant instant) const { return instant == Instant::last ? x_previous_ : weighted_; }
  void take_positions();  // without contact forces
  void take_weighted();
  void touch();  // from positions without contact forces to those with them
  double inertia() const { return motion_.scheme().inertia(motion_.step()); }
  const Vector& elastic_behind() const {  // K and C of what is behind
    return last_.step == 0 ? last_.weighted_elastic_force : last_.elastic_force;
  }
  const Vector& viscous_behind() const { return last_.step == 0 ? last_.viscous_force : last_.viscosity_velocity; }
  Vector right_hand_side(const Vector& contact_force) const;
  Vector force_of_contacts() const;  // of the motion's unknowns; empty without contact

  const Motion& motion_;
  const State& last_;
  const Indices& seen_;
  const SceneFlow* flow_;
  SceneContact* contact_;
  StepTimes& times_;

  // Fixed within the step, (3 n).
  Vector displacement_predictor_, velocity_predictor_;  // u~ and v~, without the unknown acceleration
  Vector first_displacement_, first_velocity_;          // what is behind the first step; else empty
  Vector elastic_predictor_, viscous_predictor_;        // K u~, C v~
  Vector inner_force_;  // N, -C[(1+alpha) v~ - alpha v_n] - K[(1+alpha) u~ - alpha u_n]
  Vector scene_load_;   // N, loads, gravity and external force at t_{n+1+alpha}
  Points x_previous_;

  std::optional<TissueBalance> tissue_;  // at finite strain

  // The current iterate.
  Vector load_;                                 // N, scene_load plus the flow's
  Guess free_;                                  // m/s^2, under the load of the last solve, without contact
  AirwayPressure pressure_;                     // of the last move
  const PressureResponse* response_ = nullptr;  // once solved for where it is known
  AirwayPressure solved_at_;                    // that of free_
  Points x_free_;                               // without contact forces, under the load of free_
  Points x_, weighted_;
  bool moved_ = false;
  Contacts contacts_;
  int iterations_ = 0;

  // The result: free_, with the response to contact and to what the load has changed by.
  Vector contact_force_;  // N, (3 n); empty without contact
  Motion::Products products_;
  Vector image_;  // N, A a
};

}  // namespace plica

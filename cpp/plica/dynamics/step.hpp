#pragma once
#include "plica/contact/contacts.hpp"
#include "plica/dynamics/motion.hpp"
#include "plica/dynamics/record.hpp"
#include "plica/dynamics/state.hpp"

namespace plica {

class SceneContact;
class SceneFlow;

/// One step in the making, positions from the motion's origin: M a + C V + K U = load + contact_force with U =
/// (1+alpha) u_{n+1} - alpha u_n, V likewise, where u_n and v_n are `displacement_behind` and `velocity_behind`:
/// in the first step U_0 and V_0. A coupling moves it as often as it needs; complete() then finds its
/// acceleration.
class Step {
 public:
  /// From the state `last`, under scene_load (3 n) N at t_{n+1+alpha}; contact is null where there is none. All
  /// must outlive it.
  Step(const Motion& motion, const State& last, Vector scene_load, SceneContact* contact, StepTimes& times);

  // What a coupling needs of it.
  const Points& x_previous() const { return x_previous_; }  // (n, 3) m, at t_n
  /// At t_{n+1+alpha}, (1 + alpha) (u + h v + h^2 a / 2) - alpha u at reference positions.
  Points extrapolated_positions() const;
  /// At t_{n+1+alpha} of where it has been moved, (1 + alpha) x - alpha x_previous; as accurate as x().
  Points weighted_positions() const;
  /// Moves it under the scene's load alone.
  void move();
  /// Moves it under the flow's section pressures (s) Pa on the tissue at `loaded` (n, 3), too.
  void move(const SceneFlow& flow, const Points& loaded, const Vector& pressure);
  /// Whether contact, nodes or edges, lies in the middle of the glottis.
  bool blocks(const SceneFlow& flow) const;
  bool flow_stopped() const { return flow_stopped_; }
  void set_flow_stopped(bool stopped) { flow_stopped_ = stopped; }
  StepTimes& times() const { return times_; }

  // What contact needs of it.
  const Motion& motion() const { return motion_; }
  const State& last() const { return last_; }
  const Vector& displacement_predictor() const { return displacement_predictor_; }
  const Vector& velocity_predictor() const { return velocity_predictor_; }
  const Vector& displacement_behind() const { return displacement_behind_; }
  const Vector& velocity_behind() const { return velocity_behind_; }

  /// (n, 3) m at t_{n+1} of where it has been moved; with contact forces at the nodes of the contact surfaces and
  /// the airflow surface only.
  const Points& x() const { return x_; }
  const Contacts& contacts() const { return contacts_; }
  int iterations() const { return iterations_; }

  /// Finds the acceleration under the loads and contact forces of the last move.
  void complete();
  /// The state that the completed step leads to, its ledger and first signs still those of the last; takes what it
  /// needs out of the step.
  State end();

 private:
  void move_under_load();
  /// A a = force + inner_force, warm-started from a.
  void solve(const Vector& force, Vector& a);

  const Motion& motion_;
  const State& last_;
  SceneContact* contact_;
  StepTimes& times_;

  // Fixed within the step, (3 n).
  Vector displacement_predictor_, velocity_predictor_;  // without the unknown acceleration
  Vector displacement_behind_, velocity_behind_;
  Vector inner_force_;  // N, -C[(1+alpha) v~ - alpha v_n] - K[(1+alpha) u~ - alpha u_n]
  Vector scene_load_;   // N, loads, gravity and external force at t_{n+1+alpha}
  Points x_previous_;

  // The current iterate.
  Vector load_;               // N, scene_load plus the flow's
  Vector free_acceleration_;  // m/s^2, under `load` without contact forces
  Points x_;
  Contacts contacts_;
  bool flow_stopped_ = false;
  int iterations_ = 0;

  // The result.
  Vector contact_force_;  // N, (3 n); empty without contact
  Vector acceleration_;   // m/s^2
};

}  // namespace plica

#pragma once
#include "plica/core/stopwatch.hpp"
#include "plica/dynamics/simulation.hpp"

namespace plica {

/// One step in the making, positions from the simulation's origin: M a + C V + K U = load + contact_force with U =
/// (1+alpha) u_{n+1} - alpha u_n, V likewise, where u_n and v_n are `displacement_behind` and `velocity_behind`:
/// in the first step U_0 and V_0.
struct Simulation::Step {
  explicit Step(Simulation& simulation);

  // Fixed within the step, (3 n).
  Vector displacement_predictor, velocity_predictor;  // without the unknown acceleration
  Vector displacement_behind, velocity_behind;
  Vector inner_force;         // N, -C[(1+alpha) v~ - alpha v_n] - K[(1+alpha) u~ - alpha u_n]
  Vector scene_load;          // N, loads, gravity and external force at t_{n+1+alpha}
  Points x_previous;          // (n, 3) m, at t_n
  double depth_before = 0.0;  // m, deepest penetration at t_n

  // The current iterate.
  Vector load;               // N, scene_load plus the flow's
  Vector free_acceleration;  // m/s^2, under `load` without contact forces
  Points x;                  // (n, 3) m at t_{n+1}; with contact forces at the nodes of the contact surfaces
                             // and the airflow surface only
  Contacts contacts;
  std::optional<FlowRecord> flow;
  bool flow_stopped = false;
  int iterations = 0;

  // The result.
  Vector contact_force;  // N, (3 n); empty without contact
  Vector acceleration;   // m/s^2
};

}  // namespace plica

#pragma once
#include "plica/dynamics/first_signs.hpp"

namespace plica {

/// Energies and works since t = 0 (J), each from its own formula (docs/theory.md, "Energy ledger").
struct Ledger {
  double kinetic = 0.0;
  double elastic = 0.0;
  double load_work = 0.0;
  double contact_work = 0.0;
  double viscous_loss = 0.0;
  double numerical_loss = 0.0;
  double initial = 0.0;  // kinetic + elastic at t = 0

  /// What the terms leave unexplained; round-off and the solver's tolerance.
  double error() const {
    return kinetic + elastic - initial - load_work - contact_work + viscous_loss + numerical_loss;
  }
};

/// Everything the next step, or what is said of it, depends on. Nodal vectors are (3 n); contact_force is empty
/// where the scene has no contact, viscous_force where no material is viscous.
struct State {
  std::int64_t step = 0;
  Vector displacement, velocity, acceleration;  // m, m/s, m/s^2
  Vector load, contact_force;                   // N, as they entered the last step's equation
  Vector elastic_force, weighted_elastic_force, viscous_force, inertial_force;  // K u, K U, C V, M a
  std::vector<std::int32_t> closed;  // keys of the contact constraints that carried force, ascending
  Vector closed_force;               // (closed) N, the normal forces of these
  double depth = 0.0;                // m, >= 0: deepest penetration of a node
  bool flow_stopped = false;
  Ledger ledger;
  FirstSigns first_signs;  // of trouble since t = 0: no step depends on them, a failure's text does
};

}  // namespace plica

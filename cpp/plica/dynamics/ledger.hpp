#pragma once
#include <cstdint>
#include <vector>

#include "plica/core/types.hpp"

namespace plica {

class ExcessForce;
class Motion;
struct State;
struct SchemeCoefficients;

/// Energies and works since t = 0 (J), each from its own formula (docs/theory/energy.md).
struct Ledger {
  double kinetic = 0.0;
  double elastic = 0.0;
  double load_work = 0.0;  // of all loads, the airflow's included
  double flow_work = 0.0;  // of load_work, the airflow's
  double contact_work = 0.0;
  double viscous_loss = 0.0;
  double numerical_loss = 0.0;
  /// At finite strain: work of the tissue's force, with the weights of the loads', less the change of its energy,
  /// both beyond linear tissue's.
  double nonlinear_loss = 0.0;
  double initial = 0.0;  // kinetic + elastic at t = 0

  // The air's own account, no part of the tissue's balance.
  double air_supplied_energy = 0.0;  // pressure difference along the sections times the volume that has flowed
  double air_viscous_energy = 0.0;   // of it, lost to friction at the walls
  double air_inertial_energy = 0.0;  // of it, what accelerated the air; 0 without inertance

  /// What the terms leave unexplained; round-off and the solver's tolerance.
  double error() const {
    return kinetic + elastic - initial - load_work - contact_work + viscous_loss + numerical_loss + nonlinear_loss;
  }
};

/// What the ledger has to know of a motion.
struct LedgerMotion {
  const SchemeCoefficients& scheme;
  double step;  // s
  bool viscous;
  const Vector& shift;                        // m, Start::shift
  const std::vector<std::int32_t>& massless;  // nodes
  const ExcessForce* excess = nullptr;        // null where tissue is linear
};

/// The ledger of a state of t = 0; momentum: M v of it.
Ledger opened_ledger(const State& state, const Vector& momentum, const ExcessForce* excess = nullptr);
Ledger opened_ledger(const Motion& motion, const State& state);

/// The ledger after the step from `before` to `now`, whose forces are known and whose M v is `momentum`.
Ledger continued_ledger(const LedgerMotion& motion, const State& before, const State& now, const Vector& momentum);
Ledger continued_ledger(const Motion& motion, const State& before, const State& now);

}  // namespace plica

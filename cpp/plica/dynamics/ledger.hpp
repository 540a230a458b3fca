#pragma once

namespace plica {

class Motion;
struct State;

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

/// The ledger of a state of t = 0.
Ledger opened_ledger(const Motion& motion, const State& state);

/// The ledger after the step from `before` to `now`, whose forces are known.
Ledger continued_ledger(const Motion& motion, const State& before, const State& now);

}  // namespace plica

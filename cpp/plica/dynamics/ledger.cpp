#include "plica/dynamics/ledger.hpp"

#include <cmath>

#include "plica/core/error.hpp"
#include "plica/dynamics/motion.hpp"
#include "plica/dynamics/state.hpp"

namespace plica {

namespace {

void take_energies(const State& state, const Vector& momentum, Ledger& ledger) {
  ledger.kinetic = 0.5 * state.velocity.dot(momentum);
  ledger.elastic = 0.5 * state.displacement.dot(state.elastic_force);
}

/// At t_{n+1+alpha}, as loads are: -alpha times their difference further on is the step's middle.
double lag_of(bool first, double alpha) { return first ? alpha / (2 * (1 + alpha)) : alpha; }

/// To the ledger of a step in which the tissue's excess force was a load: docs/theory/finite_strain.md.
void add_excess(const ExcessForce& law, double alpha, const State& before, const State& now, Ledger& ledger) {
  const Vector du = now.displacement - before.displacement;
  const double late = lag_of(before.step == 0, alpha) * du.dot(now.elastic_excess - before.elastic_excess);
  const double work = 0.5 * du.dot(now.elastic_excess + before.elastic_excess) - late;
  const double energy = law.energy(now.displacement);
  if (!std::isfinite(energy))
    throw SolveFailed(
        "tissue at finite strain: a cell is inside out where the step ends; must keep its orientation. Take a "
        "shorter time.step, less pressure, or stiffer tissue.");
  const double linear_change =
      ledger.elastic - 0.5 * before.displacement.dot(before.elastic_force);  // ledger: as of linear tissue
  ledger.nonlinear_loss += work - (energy - before.ledger.elastic - linear_change);
  ledger.numerical_loss += late;
  if (now.viscous_excess.size() > 0)
    ledger.viscous_loss += 0.5 * du.dot(now.viscous_excess + before.viscous_excess);
  ledger.elastic = energy;
}

}  // namespace

Ledger opened_ledger(const State& state, const Vector& momentum, const ExcessForce* excess) {
  Ledger ledger;
  take_energies(state, momentum, ledger);
  if (excess) ledger.elastic = excess->energy(state.displacement);
  ledger.initial = ledger.kinetic + ledger.elastic;
  return ledger;
}

Ledger opened_ledger(const Motion& motion, const State& state) {
  return opened_ledger(state, motion.mass() * state.velocity, motion.excess());
}

Ledger continued_ledger(const Motion& motion, const State& before, const State& now) {
  return continued_ledger({motion.scheme(), motion.step(), motion.viscosity().has_value(), motion.start().shift,
                           motion.massless(), motion.excess()},
                          before, now, motion.mass() * now.velocity);
}

Ledger continued_ledger(const LedgerMotion& motion, const State& before, const State& now,
                        const Vector& momentum) {
  // dE = du . f_bar + du . contact_bar - du . C V_bar - D, D the scheme's own dissipation; docs/theory/energy.md.
  const auto [alpha, beta, gamma] = motion.scheme;
  const double h = motion.step;
  const bool first = before.step == 0, viscous = motion.viscous;
  const Vector du = now.displacement - before.displacement;
  const Vector da = now.acceleration - before.acceleration;

  Ledger ledger = before.ledger;
  take_energies(now, momentum, ledger);
  const double lag = lag_of(first, alpha);
  const double late = lag * du.dot(now.load - before.load);
  ledger.load_work += 0.5 * du.dot(now.load + before.load) - late;
  if (now.flow_load.size() > 0) {
    ledger.flow_work +=
        0.5 * du.dot(now.flow_load + before.flow_load) - lag * du.dot(now.flow_load - before.flow_load);
    const auto of_step = [&](double P_now, double P_before) {
      return h * (0.5 * (P_now + P_before) - lag * (P_now - P_before));
    };
    ledger.air_supplied_energy += of_step(now.supplied_power, before.supplied_power);
    ledger.air_viscous_energy += of_step(now.viscous_power, before.viscous_power);
    ledger.air_inertial_energy += of_step(now.inertial_power, before.inertial_power);
  }
  if (now.contact_force.size() > 0) ledger.contact_work += 0.5 * du.dot(now.contact_force + before.contact_force);
  if (viscous) ledger.viscous_loss += 0.5 * du.dot(now.viscous_force + before.viscous_force);
  const Vector d_inertia = now.inertial_force - before.inertial_force;
  ledger.numerical_loss +=
      -h * (gamma - 0.5) * 0.5 * (now.velocity + before.velocity).dot(d_inertia) +
      h * h * (beta - 0.5 * gamma) * 0.5 * da.dot(now.inertial_force + before.inertial_force) +
      0.5 * du.dot(now.weighted_elastic_force + before.weighted_elastic_force - now.elastic_force -
                   before.elastic_force) -
      late;
  if (first) {
    ledger.numerical_loss += 0.5 * motion.shift.dot(now.inertial_force + before.inertial_force);
    // What was out of balance at nodes without mass at t = 0 is so no more: they have moved at once.
    for (const auto node : motion.massless) {
      const std::ptrdiff_t at = 3 * static_cast<std::ptrdiff_t>(node);
      Vector3 force = before.load.segment<3>(at) - before.weighted_elastic_force.segment<3>(at);
      if (viscous) force -= before.viscous_force.segment<3>(at);
      ledger.numerical_loss += 0.5 * du.segment<3>(at).dot(force);
    }
  }
  if (motion.excess) add_excess(*motion.excess, alpha, before, now, ledger);
  return ledger;
}

}  // namespace plica

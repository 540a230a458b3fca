#include "plica/dynamics/explicit_motion.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "plica/core/error.hpp"
#include "plica/core/stopwatch.hpp"
#include "plica/core/threads.hpp"
#include "plica/dynamics/coupling.hpp"
#include "plica/dynamics/scene_contact.hpp"
#include "plica/dynamics/scene_flow.hpp"

namespace plica {

namespace {

[[noreturn]] void refuse(const std::string& what, const std::string& instead) {
  throw InvalidInput("Simulation: central differences with " + what + "; must be " + instead + ".");
}

void require_explicit(const Scene& scene, const Motion::Options& options) {
  if (options.mass != CellMass::lumped) refuse("a consistent mass", "a lumped one: nothing is solved for");
  if (scene.symmetry) refuse("a symmetry", "without, or another scheme");
  if (scene.reduction) refuse("a reduction", "another scheme, whose steps of few coordinates are not limited");
  if (!scene.contact) return;
  const ContactPart& part = *scene.contact;
  if (!std::holds_alternative<Penalty>(part.enforcement) &&
      !std::holds_alternative<VolumePenalty>(part.enforcement))
    refuse("contact that is solved for", "a penalty: its forces follow from positions alone");
  if (part.friction) refuse("friction", "left out, or another scheme: it is solved for");
  if (part.surface_mass == SurfaceMass::redistributed)
    refuse("massless contact nodes", "nodes that have mass, surface_mass = \"kept\"");
}

/// (3 n) of the lumped mass, whose matrix is diagonal.
Vector diagonal(const NodalMatrix& mass) {
  Vector masses(mass.rows());
  for (std::int32_t i = 0; i < mass.pattern()->rows(); ++i)
    masses.segment<3>(3 * static_cast<std::ptrdiff_t>(i))
        .setConstant(mass.values()[static_cast<std::size_t>(mass.pattern()->find(i, i))]);
  return masses;
}

Vector inverse(const Vector& mass, const Supports& supports) {
  Vector inverse = mass.cwiseInverse();
  supports.project(inverse);
  return inverse;
}

/// 1/s^2, a bound of the largest eigenvalue of M^-1 K_c where all nodes of the surfaces are in contact: see
/// contact_stiffness, each node facing one.
double stiffness_of_all(const Scene& scene, const Vector& inverse_mass) {
  const Penalty* penalty = scene.contact ? std::get_if<Penalty>(&scene.contact->enforcement) : nullptr;
  if (!penalty) return 0.0;
  double lightest = 0.0;
  int free_sides = 0;
  for (const Triangles* side : {&scene.contact->airway.first, &scene.contact->airway.second}) {
    double of_side = 0.0;
    for (const std::int32_t node : side->reshaped())
      of_side = std::max(of_side, inverse_mass.segment<3>(3 * static_cast<std::ptrdiff_t>(node)).maxCoeff());
    free_sides += of_side > 0;
    lightest = std::max(lightest, of_side);
  }
  return free_sides * penalty->stiffness * lightest;
}

/// The same of the closed rows: K_c = sum of p g^T / compliance, p and g a row's push and gap, along each other.
/// By Cauchy and Schwarz it is below the diagonal D_i = sum |p| |g_i| / compliance, |p| summed over free nodes.
struct Stiffest {
  double value = 0.0;  // 1/s^2
  std::int32_t node = -1;
};
Stiffest contact_stiffness(const Contacts& contacts, const Vector& inverse_mass) {
  std::vector<std::pair<std::int32_t, double>> shares;
  const auto lightness = [&](std::int32_t node) {
    return inverse_mass.segment<3>(3 * static_cast<std::ptrdiff_t>(node)).maxCoeff();
  };
  for (std::size_t j = 0; j < contacts.rows.size(); ++j) {
    const Row& row = contacts.rows[j];
    if (!(contacts.force[static_cast<std::ptrdiff_t>(j)] > 0)) continue;
    double pushed = 0.0;
    for (const auto& [node, vector] : row.push)
      if (lightness(node) > 0) pushed += vector.norm();
    for (const auto& [node, vector] : row.gap)
      shares.emplace_back(node, pushed * vector.norm() / row.compliance * lightness(node));
  }
  std::sort(shares.begin(), shares.end());
  Stiffest stiffest;
  double sum = 0.0;
  for (std::size_t k = 0; k < shares.size(); ++k) {
    sum = (k > 0 && shares[k].first == shares[k - 1].first ? sum : 0.0) + shares[k].second;
    if (sum > stiffest.value) stiffest = {sum, shares[k].first};
  }
  return stiffest;
}

}  // namespace

ExplicitMotion::ExplicitMotion(const Scene& scene, const Motion& motion)
    : motion_(motion),
      coupling_(scene.airflow ? scene.airflow->coupling : Coupling(Lagged{})),
      mass_((require_explicit(scene, motion.options()), diagonal(motion.mass()))),
      inverse_mass_(inverse(mass_, motion.supports())),
      stable_(inverse_mass_, motion.stiffness(), motion.viscosity()),
      contact_stiffness_(stiffness_of_all(scene, inverse_mass_)),
      eigenvalue_(stable_.eigenvalue(motion.step())) {
  const double h = motion.step();
  if (eigenvalue_ + 0.25 * h * h * contact_stiffness_ <= 1) return;
  throw InvalidInput("Simulation", "step", h, "s", "<= " + number_text(largest_step()) + " s",
                     "Central differences are not stable with longer ones; hht and newmark are with any.");
}

void ExplicitMotion::require_stable(const Contacts& contacts) const {
  const auto [value, node] = contact_stiffness(contacts, inverse_mass_);
  const double h = motion_.step();
  if (eigenvalue_ + 0.25 * h * h * value <= 1) return;
  throw SolveFailed("Contact: its stiffness at node " + std::to_string(node) + " asks for steps of at most " +
                    number_text(stable_.largest(value)) + " s; the step is " + number_text(h) +
                    " s. Shorten the step, or lower the stiffness of the penalty.");
}

Vector ExplicitMotion::momentum(const Vector& velocity) const { return mass_.cwiseProduct(velocity); }

Ledger ExplicitMotion::opened_ledger(const State& state) const {
  return plica::opened_ledger(state, momentum(state.velocity));
}

Ledger ExplicitMotion::continued_ledger(const State& before, const State& now) const {
  const Vector still = Vector::Zero(before.step == 0 ? mass_.size() : 0);  // no step of theirs is shifted
  return plica::continued_ledger(
      {motion_.scheme(), motion_.step(), motion_.viscosity().has_value(), still, motion_.massless()}, before, now,
      momentum(now.velocity));
}

void ExplicitMotion::accelerate(const State& last, const Vector& velocity, State& now) const {
  const double h = motion_.step();
  const bool first = last.acceleration.size() == 0, touching = now.contact_force.size() > 0;
  const BlockMatrix& K = motion_.stiffness();
  const auto& C = motion_.viscosity();
  for (Vector* v : {&now.acceleration, &now.elastic_force, &now.inertial_force}) v->resize(mass_.size());
  if (C) now.viscous_force.resize(mass_.size());
  if (!first) now.velocity.resize(mass_.size());
  for_chunks(
      K.pattern()->rows(), BlockMatrix::chunk_rows, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
        const auto part = [at = 3 * begin, count = 3 * (end - begin)](auto& v) { return v.segment(at, count); };
        K.multiply_rows(begin, end, now.displacement, now.elastic_force);
        part(now.acceleration) = part(now.load) - part(now.elastic_force);
        if (C) {
          C->multiply_rows(begin, end, velocity, now.viscous_force);
          part(now.acceleration) -= part(now.viscous_force);
        }
        if (touching) part(now.acceleration) += part(now.contact_force);
        part(now.acceleration).array() *= part(inverse_mass_).array();
        part(now.inertial_force) = part(mass_).cwiseProduct(part(now.acceleration));
        if (!first)
          part(now.velocity) = part(last.velocity) + 0.5 * h * (part(last.acceleration) + part(now.acceleration));
      });
  now.weighted_elastic_force = now.elastic_force;
}

void ExplicitMotion::begin(State& state) const { accelerate(State{}, state.velocity, state); }

ExplicitMotion::Taken ExplicitMotion::step(const State& last, Vector scene_load, const SceneFlow* flow,
                                           SceneContact* contact, StepTimes& times) const {
  const double h = motion_.step();
  Taken taken;
  State& now = taken.now;
  now.step = last.step + 1;
  Vector velocity(mass_.size());  // v^, of which the viscous forces are
  {
    const Stopwatch watch(times.residual);
    now.displacement.resize(mass_.size());
    for_slices(mass_.size(), [&](std::ptrdiff_t at, std::ptrdiff_t count) {
      const auto part = [&](auto& v) { return v.segment(at, count); };
      part(now.displacement) =
          part(last.displacement) + h * part(last.velocity) + 0.5 * h * h * part(last.acceleration);
      part(velocity) = part(last.velocity) + h * part(last.acceleration);
    });
  }
  Points x;
  if (flow || contact) {
    taken.x_previous = motion_.positions(last.displacement);
    x = motion_.positions(now.displacement);
  }
  if (contact) {
    const Stopwatch watch(times.contact);
    contact->begin(taken.x_previous, last.depth);
    taken.contacts = contact->forces_at(x, taken.x_previous, last);
    require_stable(taken.contacts);
    now.contact_force = Vector::Zero(mass_.size());
    if (taken.contacts.any_force()) taken.contacts.add_forces(now.contact_force);
    std::tie(now.closed, now.closed_force) = taken.contacts.closed();
  }
  now.load = std::move(scene_load);
  if (flow) {
    const Stopwatch watch(times.load);
    now.flow_stopped = contact && contact->blocks(*flow, taken.contacts, x, taken.x_previous, last.depth);
    const CoupledStep::Instant instant = load_instant(coupling_);
    const bool lagged = instant == CoupledStep::Instant::last;
    const Points& at = lagged ? taken.x_previous : x;
    const Airflow& airflow = flow->airflow();
    const auto through = [&](const Points& shape, CoupledStep::Instant then, bool stopped) {
      const Air air = airflow.air(CoupledStep::time(then, last.step, h, motion_.scheme().alpha));
      return airflow.evaluate(flow->areas(shape), air, stopped);
    };
    taken.flow = FlowRecord{through(at, instant, lagged ? last.flow_stopped : now.flow_stopped), 1};
    const FlowState& state = taken.flow->state;
    if (lagged)
      taken.flow->residual = pressure_difference(
          airflow, state.pressure, through(x, CoupledStep::Instant::weighted, now.flow_stopped).pressure);
    flow->add_load(at, state.subglottal_pressure, state.pressure, now.load);
  }
  const Stopwatch watch(times.solve);
  accelerate(last, velocity, now);
  now.ledger = last.ledger;
  now.first_signs = last.first_signs;
  return taken;
}

}  // namespace plica

#include "plica/dynamics/motion.hpp"

#include <algorithm>
#include <cmath>

#include "plica/core/error.hpp"
#include "plica/dynamics/state.hpp"

namespace plica {

namespace {

/// Nodes of the two sides of a contact, ascending.
/// A node that is held does not move, so its mass does no harm: it stays.
std::vector<std::int32_t> massless_nodes(const Scene& scene) {
  if (!scene.contact || scene.contact->surface_mass == SurfaceMass::kept) return {};
  std::vector<std::int32_t> nodes = surface_nodes(scene.contact->airway);
  const auto held = [&](std::int32_t node) { return scene.supports.node_fixed(node); };
  nodes.erase(std::remove_if(nodes.begin(), nodes.end(), held), nodes.end());
  return nodes;
}

NodalMatrix assemble_mass(const Assembler& assembler, const Tissue& tissue, CellMass kind,
                          const std::vector<std::int32_t>& massless) {
  if (!massless.empty()) {
    std::vector<char> marked(static_cast<std::size_t>(assembler.pattern()->rows()), 0);
    for (const auto node : massless) marked[static_cast<std::size_t>(node)] = 1;
    return assembler.redistributed_mass(tissue, kind, marked);
  }
  if (kind == CellMass::consistent) return assembler.mass(tissue);
  const Vector lumped = assembler.lumped_mass(tissue);
  NodalMatrix mass(assembler.pattern());
  for (std::int32_t i = 0; i < lumped.size(); ++i) mass.values()[assembler.pattern()->find(i, i)] = lumped[i];
  return mass;
}

std::optional<BlockMatrix> assemble_viscosity(const Assembler& assembler, const Tissue& tissue) {
  const bool viscous = std::any_of(tissue.materials.begin(), tissue.materials.end(),
                                   [](const Material& m) { return m.viscosity > 0; });
  if (!viscous) return std::nullopt;
  return assembler.viscosity(tissue);
}

BlockMatrix assemble_step_matrix(const SchemeCoefficients& s, double h, const NodalMatrix& M,
                                 const std::optional<BlockMatrix>& C, const BlockMatrix& K,
                                 const Supports& supports) {
  return combine_matrices(1.0, M, (1 + s.alpha) * s.gamma * h, C, (1 + s.alpha) * s.beta * h * h, K, supports);
}

}  // namespace

void Motion::Options::validate() const {
  coefficients(scheme);
  if (!(step > 0) || !std::isfinite(step)) throw InvalidInput("Simulation", "step", step, "s", "> 0 and finite");
  solver.validate();
}

Motion::Motion(const Scene& scene, const Assembler& assembler, const Options& options)
    : scene_(scene),
      options_(options),
      scheme_(coefficients(options_.scheme)),
      origin_(origin_near(scene.mesh.points)),
      reference_(scene.mesh.points.rowwise() - origin_.transpose()),
      massless_(massless_nodes(scene)),
      mass_(assemble_mass(assembler, scene.tissue, options_.mass, massless_)),
      stiffness_(assembler.stiffness(scene.tissue)),
      viscosity_(assemble_viscosity(assembler, scene.tissue)),
      step_matrix_(assemble_step_matrix(scheme_, options_.step, mass_, viscosity_, stiffness_, scene.supports)),
      solver_(LinearSolver::make(step_matrix_, options_.solver)) {}

void Motion::begin(State& state) {
  state.elastic_force = stiffness_ * state.displacement;
  StartForces forces{state.load - state.elastic_force, Vector::Zero(state.load.size())};
  if (viscosity_) forces.viscous = -(*viscosity_ * state.velocity);
  Supports without_acceleration = supports();
  for (const auto node : massless_) without_acceleration.fix(node);
  without_acceleration.project(forces.elastic_and_load);
  without_acceleration.project(forces.viscous);
  start_ = start_motion(scheme_, step(), {mass_, viscosity_, stiffness_, without_acceleration}, forces,
                        options_.solver.krylov());
  state.acceleration = start_.acceleration;
  state.weighted_elastic_force = stiffness_ * Vector(state.displacement + start_.displacement);
  if (viscosity_) state.viscous_force = *viscosity_ * Vector(state.velocity + start_.velocity);
  state.inertial_force = mass_ * state.acceleration;
}

int Motion::solve(Vector force, Vector& a) const {
  supports().project(force);
  Guess guess{std::move(a), {}};
  const Convergence end = solver_->solve(force, guess);
  a = std::move(guess.x);
  if (!end.converged)
    throw SolveFailed(solver_->name() + " stopped at residual " + number(end.residual) + " after " +
                      std::to_string(end.iterations) + " iterations (tolerance " + number(solver_->tolerance()) +
                      "). Try a smaller step, or raise max_iterations.");
  return end.iterations;
}

void Motion::take_forces(const State& before, State& now) const {
  const double alpha = scheme_.alpha;
  const bool first = before.step == 0;
  now.elastic_force = stiffness_ * now.displacement;
  now.weighted_elastic_force =
      (1 + alpha) * now.elastic_force - alpha * (first ? before.weighted_elastic_force : before.elastic_force);
  if (viscosity_) {
    Vector rate = (1 + alpha) * now.velocity - alpha * before.velocity;
    if (first) rate -= alpha * start_.velocity;
    now.viscous_force = *viscosity_ * rate;
  }
  now.inertial_force = mass_ * now.acceleration;
}

}  // namespace plica

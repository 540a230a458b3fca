#include "plica/dynamics/motion.hpp"

#include <algorithm>
#include <cmath>

#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "plica/dynamics/rigid_motion.hpp"
#include "plica/dynamics/state.hpp"

namespace plica {

namespace {

/// Nodes of the two sides of a contact, ascending, as the solved tissue counts them.
/// A node that is held does not move, so its mass does no harm: it stays.
std::vector<std::int32_t> massless_nodes(const Scene& scene, const SymmetricPart* part) {
  if (!scene.contact || scene.contact->surface_mass == SurfaceMass::kept) return {};
  std::vector<std::int32_t> nodes = surface_nodes(scene.contact->airway);
  const auto held = [&](std::int32_t node) { return scene.supports.node_fixed(node); };
  nodes.erase(std::remove_if(nodes.begin(), nodes.end(), held), nodes.end());
  if (!part) return nodes;
  for (std::int32_t& node : nodes) node = part->images.node_of(node);
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

/// What the massless nodes of the solved tissue give their mass to. Of a symmetric part no body is free: such are
/// refused.
MassTransfer mass_transfer(const Scene& scene, const SymmetricPart* part,
                           const std::vector<std::int32_t>& massless) {
  const TetMesh& solved = part ? part->mesh : scene.mesh;
  const std::vector<char> none(static_cast<std::size_t>(solved.node_count()), 0);
  MassTransfer transfer{none, none, none};
  for (const auto node : massless) transfer.massless[static_cast<std::size_t>(node)] = 1;
  // What the planes of symmetry hold besides is not held in the scene.
  for (std::int32_t node = 0; node < solved.node_count(); ++node)
    transfer.held[static_cast<std::size_t>(node)] =
        scene.supports.node_fixed(part ? part->images.nodes()[node] : node);
  if (part) return transfer;
  const Indices body = body_of_nodes(solved);
  for (const RigidMotion& motion : rigid_motions(solved, scene.supports))
    for (std::int32_t node = motion.body; node < solved.node_count(); ++node)
      if (body[node] == motion.body) transfer.free[static_cast<std::size_t>(node)] = 1;
  return transfer;
}

NodalMatrix assemble_mass(const Assembler& assembler, const Scene& scene, const SymmetricPart* part, CellMass kind,
                          const std::vector<std::int32_t>& massless) {
  const Tissue& tissue = part ? part->tissue : scene.tissue;
  if (!massless.empty()) return assembler.redistributed_mass(tissue, kind, mass_transfer(scene, part, massless));
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
  scheme_coefficients(scheme);
  if (!(step > 0) || !std::isfinite(step)) throw InvalidInput("Simulation", "step", step, "s", "> 0 and finite");
  solver.validate();
}

Motion::Motion(const Scene& scene, const SymmetricPart* part, const Assembler& assembler, const Options& options)
    : scene_(scene),
      part_(part),
      options_(options),
      scheme_(scheme_coefficients(options_.scheme)),
      origin_(origin_near(scene.mesh.points)),
      reference_(scene.mesh.points.rowwise() - origin_.transpose()),
      massless_(massless_nodes(scene, part)),
      mass_(assemble_mass(assembler, scene, part, options_.mass, massless_)),
      stiffness_(assembler.stiffness(part ? part->tissue : scene.tissue)),
      viscosity_(assemble_viscosity(assembler, part ? part->tissue : scene.tissue)) {
  if (part_) {  // S^T M S of all copies
    std::vector<std::vector<double>*> matrices{&mass_.values(), &stiffness_.values()};
    if (viscosity_) matrices.push_back(&viscosity_->values());
    for (std::vector<double>* values : matrices)
      for (double& value : *values) value *= part_->images.copies();
  }
  if (scene.strain)
    excess_.emplace(*scene.strain, part_ ? part_->mesh : scene.mesh, part_ ? part_->tissue : scene.tissue,
                    stiffness_, viscosity_, supports(), part_ ? part_->images.copies() : 1);
  if (is_explicit() || scene.reduction) return;
  step_matrix_ = assemble_step_matrix(scheme_, options_.step, mass_, viscosity_, stiffness_, supports());
  solver_ = LinearSolver::make(*step_matrix_, options_.solver);
}

const BlockMatrix& Motion::step_matrix() const {
  if (!step_matrix_)
    throw InvalidInput(
        "Simulation: step_matrix; must be of a scene whose steps solve with it. Central differences have the "
        "lumped "
        "mass alone, reduced scenes their few coordinates.");
  return *step_matrix_;
}

void Motion::begin(State& state) {
  state.elastic_force = stiffness_ * state.displacement;
  StartForces forces{state.load - state.elastic_force, Vector::Zero(state.load.size())};
  if (viscosity_) forces.viscous = -(*viscosity_ * state.velocity);
  if (excess_) {
    ExcessForce::Force excess = excess_->at_start(state.displacement, state.velocity);
    forces.elastic_and_load -= excess.elastic;
    if (viscosity_) forces.viscous -= excess.viscous;
    state.elastic_excess = std::move(excess.elastic);
    state.viscous_excess = std::move(excess.viscous);
  }
  Supports without_acceleration = supports();
  for (const auto node : massless_) without_acceleration.fix(node);
  without_acceleration.project(forces.elastic_and_load);
  without_acceleration.project(forces.viscous);
  start_ = start_motion(scheme_, step(), {mass_, viscosity_, stiffness_, without_acceleration}, forces,
                        options_.solver.krylov());
  state.acceleration = start_.acceleration;
  state.weighted_elastic_force = stiffness_ * Vector(state.displacement + start_.displacement);
  if (viscosity_) state.viscous_force = *viscosity_ * Vector(state.velocity + start_.velocity);
  Products products = this->products(state.acceleration);
  state.past.add(state.acceleration, image(products));
  state.inertial_force = std::move(products.inertial);
  state.stiffness_velocity = stiffness_ * state.velocity;
  state.stiffness_acceleration = std::move(products.elastic);
  if (viscosity_) state.viscosity_velocity = *viscosity_ * state.velocity;
  state.viscosity_acceleration = std::move(products.viscous);
}

int Motion::solve(const Vector& force, Guess& guess, double tolerance) const {
  return checked(solver_->solve(force, guess, tolerance), tolerance);
}

int Motion::solve(const Vector& force, Guess& guess, Products& products) const {
  const double tolerance = solver_->tolerance();
  return checked(solver_->solve(force, guess, tolerance,
                                [&](const Vector& a, Vector& image) {
                                  products = this->products(a);
                                  image = this->image(products);
                                }),
                 tolerance);
}

int Motion::checked(const Convergence& end, double tolerance) const {
  if (!end.converged)
    throw SolveFailed(
        solver_->name() + " stopped at residual " + number_text(end.residual) + " after " +
        std::to_string(end.iterations) + " iterations (tolerance " + number_text(tolerance) +
        "). Try a smaller step, or raise max_iterations of solver.method, cholesky or conjugate_gradients.");
  return end.iterations;
}

Motion::Products Motion::products(const Vector& a) const {
  return {mass_ * a, viscosity_ ? *viscosity_ * a : Vector(), stiffness_ * a};
}

Vector Motion::image(const Products& products) const {
  const double c = (1 + scheme_.alpha) * scheme_.gamma * step(),
               k = (1 + scheme_.alpha) * scheme_.beta * step() * step();
  Vector image(products.inertial.size());
  for_slices(image.size(), [&](std::ptrdiff_t at, std::ptrdiff_t count) {
    image.segment(at, count) = products.inertial.segment(at, count) + k * products.elastic.segment(at, count);
    if (viscosity_) image.segment(at, count) += c * products.viscous.segment(at, count);
  });
  supports().project(image);
  return image;
}

}  // namespace plica

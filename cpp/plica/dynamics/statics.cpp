#include "plica/dynamics/statics.hpp"

#include <cmath>

#include "plica/core/error.hpp"
#include "plica/dynamics/rigid_motion.hpp"
#include "plica/solve/factorization.hpp"

namespace plica {

namespace {

std::string direction(const Vector3& v) {
  const Vector3 unit = v.unaryExpr([](double c) { return std::abs(c) < 1e-6 ? 0.0 : c; });
  return "(" + number_text(unit[0]) + ", " + number_text(unit[1]) + ", " + number_text(unit[2]) + ")";
}

void check_supported(const TetMesh& mesh, const Supports& supports) {
  const std::vector<RigidMotion> free = rigid_motions(mesh, supports);
  if (free.empty()) return;
  const RigidMotion& first = free.front();
  throw InvalidInput("Scene: the body of node " + std::to_string(first.body) + ", centred at (" +
                     number_text(first.centre[0]) + ", " + number_text(first.centre[1]) + ", " +
                     number_text(first.centre[2]) + ") m, can " + (first.turns ? "turn about " : "shift along ") +
                     direction(first.along) +
                     " without strain; must be held for an equilibrium. Hold more of its nodes, or follow its "
                     "motion in time.");
}

/// Gravity and the loads at t = 0, N.
Vector load_at_rest(const Scene& scene, const Assembler& assembler) {
  Vector load = Vector::Zero(3 * scene.mesh.node_count());
  if (scene.gravity) load += assembler.body_force(scene.tissue, *scene.gravity);
  for (const Load& part : scene.loads)
    load += std::cos(part.phase) * assembler.traction(scene.mesh.surface(part.surface), part.traction);
  return load;
}

}  // namespace

Points equilibrium(const Scene& scene) {
  scene.validate();
  check_supported(scene.mesh, scene.supports);
  const Assembler assembler(scene.mesh);
  Vector load = load_at_rest(scene, assembler);
  scene.supports.project(load);
  BlockMatrix K = assembler.stiffness(scene.tissue);
  scene.supports.constrain(K);
  return as_points(Factorization(K.to_sparse()).solve(load));
}

ContactEquilibrium contact_equilibrium(const Scene& scene) {
  scene.validate();
  check_supported(scene.mesh, scene.supports);
  if (!scene.contact)
    throw InvalidInput("Scene: contact is missing; must be there for an equilibrium in contact.");
  const ContactPart& part = *scene.contact;
  std::unique_ptr<ContactMethod> method = contact_method(part.enforcement);
  if (method->needs_stress())
    throw InvalidInput(
        "Scene: contact = Nitsche's method; must be multipliers, augmented multipliers or a penalty at rest. Its "
        "gamma belongs to a time step.");
  const Assembler assembler(scene.mesh);
  BlockMatrix K = assembler.stiffness(scene.tissue);
  Vector held = Vector::Zero(3 * scene.mesh.node_count());
  if (scene.displacement) {
    held = as_vector(*scene.displacement);
    Vector free = held;
    scene.supports.project(free);
    held -= free;
  }
  const Vector load = load_at_rest(scene, assembler) - K * held;
  scene.supports.constrain(K);
  const Factorization factors(K.to_sparse());
  const auto displaced = [&](Vector force) -> Vector {
    scene.supports.project(force);
    return held + factors.solve(force);
  };

  const std::vector<std::int32_t> on_surfaces = surface_nodes(part.airway);
  const Indices nodes =
      Eigen::Map<const Indices>(on_surfaces.data(), static_cast<std::ptrdiff_t>(on_surfaces.size()));
  const Points reference = scene.mesh.points.rowwise() - origin_near(scene.mesh.points).transpose();
  Collision collision(part.airway, reference, std::move(method), part.friction, part.options,
                      direct_solver(factors, scene.supports, nodes), part.faces);
  const Points x_free = reference + as_points(displaced(load));
  Points x;
  const std::vector<std::int32_t> none;
  const Contacts contacts = collision.solve(x_free, 1.0, {reference, none, {}, 0.0}, {}, x);
  if (!contacts.converged)
    throw SolveFailed("Contact: gap error " + number_text(contacts.gap_error) + " m after " +
                      (contacts.augmentations > 0
                           ? std::to_string(contacts.augmentations) +
                                 " augmentations at rest. Try a larger stiffness, or more augmentations."
                           : std::to_string(contacts.passes) + " passes at rest. Try a larger tolerance."));

  ContactEquilibrium rest;
  rest.contact_force = Vector::Zero(load.size());
  contacts.add_forces(rest.contact_force);
  rest.displacement = as_points(displaced(load + rest.contact_force));
  Vector closed_force;
  std::tie(rest.closed, closed_force) = contacts.closed();
  x = reference + rest.displacement;
  collision.update(x);
  rest.contact_pressure = collision.pressure({rest.contact_force, rest.closed, closed_force}, x);
  rest.passes = contacts.passes;
  rest.pivots = contacts.pivots;
  return rest;
}

}  // namespace plica

#include "plica/dynamics/statics.hpp"

#include <cmath>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/dynamics/rigid_motion.hpp"
#include "plica/dynamics/static_way.hpp"
#include "plica/solve/factorization.hpp"

namespace plica {

namespace {

std::string direction(const Vector3& v) {
  const Vector3 unit = v.unaryExpr([](double c) { return std::abs(c) < 1e-6 ? 0.0 : c; });
  return "(" + number_text(unit[0]) + ", " + number_text(unit[1]) + ", " + number_text(unit[2]) + ")";
}

/// The scene, if it is valid and no body of it can move without strain.
const Scene& supported(const Scene& scene) {
  scene.validate();
  const std::vector<RigidMotion> free = rigid_motions(scene.mesh, scene.supports);
  if (free.empty()) return scene;
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

/// The walk with the share of the load that acts.
Points stretched_equilibrium(const Scene& scene) {
  const StretchedStatics statics(scene);
  StaticWay way;
  way.balance = [&](const Vector& u, double share) -> Assembler::Stretched {
    BlockMatrix slope = statics.slope(u);
    return {-statics.unbalanced(u, share), std::move(slope)};
  };
  way.moved = [&](double, double) -> Vector { return Vector::Zero(3 * scene.mesh.node_count()); };
  way.name = "Scene";
  way.of = "gravity and loads";
  way.hint = "Take less of them, stiffer tissue, or hold more of its nodes.";
  return as_points(walk(scene.mesh, scene.supports, way).displacement);
}

}  // namespace

StretchedStatics::StretchedStatics(const Scene& scene)
    : scene_(supported(scene)),
      assembler_(scene.mesh),
      force_(scene.mesh, scene.tissue),
      load_(load_at_rest(scene, assembler_)) {}

Vector StretchedStatics::unbalanced(const Vector& u, double share) const {
  InternalForce::Force own;
  if (const auto cell = force_.at(u, Vector::Zero(u.size()), own))
    throw CellInverted("cell " + std::to_string(*cell) + " at " +
                       place_text(scene_.mesh.points(scene_.mesh.cells.row(*cell), Eigen::all).colwise().mean()) +
                       " turns inside out");
  Vector left = share * load_ - own.elastic;
  scene_.supports.project(left);
  return left;
}

BlockMatrix StretchedStatics::slope(const Vector& u) const {
  require_size("StretchedStatics", "u", u.size(), 3 * scene_.mesh.node_count());
  return assembler_.stretched(scene_.tissue, scene_.mesh.points + as_points(u)).slope;
}

Points equilibrium(const Scene& scene) {
  if (scene.strain) return stretched_equilibrium(scene);
  supported(scene);
  const Assembler assembler(scene.mesh);
  Vector load = load_at_rest(scene, assembler);
  scene.supports.project(load);
  BlockMatrix K = assembler.stiffness(scene.tissue);
  scene.supports.constrain(K);
  return as_points(Factorization(K.to_sparse()).solve(load));
}

ContactEquilibrium contact_equilibrium(const Scene& scene) {
  supported(scene);
  if (!scene.contact)
    throw InvalidInput("Scene: contact is missing; must be there for an equilibrium in contact.");
  const ContactPart& part = *scene.contact;
  std::unique_ptr<ContactMethod> method = contact_method(part.enforcement);
  if (method->needs_stress())
    throw InvalidInput(
        "Scene: contact = Nitsche's method; must be multipliers, augmented multipliers or a penalty at rest. Its "
        "gamma belongs to a time step.");
  if (scene.strain) throw InvalidInput("Scene: strain = finite; must be without for an equilibrium in contact.");
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

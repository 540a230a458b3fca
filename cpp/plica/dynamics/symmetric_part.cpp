#include "plica/dynamics/symmetric_part.hpp"

#include <algorithm>
#include <set>
#include <tuple>

#include "plica/core/error.hpp"
#include "plica/dynamics/rigid_motion.hpp"

namespace plica {

namespace {

[[noreturn]] void refuse(const std::string& what) {
  throw InvalidInput("Scene: symmetry with " + what + ". Leave symmetry out, or choose another.");
}

/// Of bodies that can move without strain all moments of the mass are kept, which are those of all copies.
void refuse_free_bodies(const Scene& scene) {
  const Indices body = body_of_nodes(scene.mesh);
  const std::vector<std::int32_t> nodes = surface_nodes(scene.contact->airway);
  for (const RigidMotion& motion : rigid_motions(scene.mesh, scene.supports))
    if (std::any_of(nodes.begin(), nodes.end(), [&](std::int32_t node) { return body[node] == motion.body; }))
      refuse("contact.surface_mass = \"redistributed\" and a body, that of node " + std::to_string(motion.body) +
             ", that its supports let " + (motion.turns ? "turn" : "shift") +
             " without strain; must be held, or surface_mass \"kept\"");
}

/// The scene, where nothing in it rules out a symmetry.
const Scene& known(const Scene& scene) {
  if (!scene.contact) return scene;
  if (scene.contact->surface_mass == SurfaceMass::redistributed) refuse_free_bodies(scene);
  if (std::holds_alternative<Nitsche>(scene.contact->enforcement))
    refuse("contact by Nitsche's method; must be another: it sees the stress of all the tissue");
  return scene;
}

/// The elasticity matrix of a material's mirror image in these planes.
Matrix6 mirrored(const Matrix6& elasticity, unsigned planes) {
  Vector3 sign(planes & 1 ? -1 : 1, planes & 2 ? -1 : 1, 1);
  Vector6 turned;  // xx yy zz xy yz zx
  turned << 1, 1, 1, sign[0] * sign[1], sign[1] * sign[2], sign[2] * sign[0];
  return turned.asDiagonal() * elasticity * turned.asDiagonal();
}

bool alike(const Material& one, const Material& other, unsigned planes) {
  constexpr double share = 1e-12;  // by which round-off may part the two
  const Matrix6 a = elasticity_matrix(one), b = mirrored(elasticity_matrix(other), planes);
  return (a - b).cwiseAbs().maxCoeff() <= share * a.cwiseAbs().maxCoeff() && one.density == other.density &&
         one.viscosity == other.viscosity && one.stiffening == other.stiffening &&
         one.matrix_stiffening == other.matrix_stiffening && one.active_stress == other.active_stress;
}

void require_symmetric_tissue(const Scene& scene, const MirrorImages& images) {
  const Tissue& tissue = scene.tissue;
  std::set<std::tuple<std::size_t, std::size_t, unsigned>> known;
  for (std::int32_t c = 0; c < scene.mesh.cell_count(); ++c) {
    const std::int32_t own = images.cells()[images.cell_of()[c]];
    unsigned planes = 0;
    for (std::size_t plane = 0; plane < images.planes(); ++plane)
      for (const std::int32_t node : scene.mesh.cells.row(c))
        if (images.mirrored(plane, node)) planes |= 1U << plane;
    const auto here = static_cast<std::size_t>(tissue.cell_material[c]),
               there = static_cast<std::size_t>(tissue.cell_material[own]);
    if (!known.emplace(here, there, planes).second) continue;
    if (alike(tissue.materials[here], tissue.materials[there], planes)) continue;
    const Vector3 at = scene.mesh.points(scene.mesh.cells.row(c), Eigen::all).colwise().mean();
    const Vector3 image = scene.mesh.points(scene.mesh.cells.row(own), Eigen::all).colwise().mean();
    throw InvalidInput(
        "Scene: symmetry: the tissue " + tissue.names[here] + " at " + place_text(at) +
        " is not the mirror image of " + tissue.names[there] + " at " + place_text(image) +
        "; must have its density, viscosity, stiffening, matrix_stiffening and active stress, and its "
        "stiffness with the fibre mirrored. Leave symmetry out, or make them equal.");
  }
}

Supports supports_of(const Scene& scene, const MirrorImages& images) {
  Supports part(images.nodes().size());
  for (std::int32_t node = 0; node < scene.mesh.node_count(); ++node) {
    const std::int32_t own = images.node_of(node);
    for (int c = 0; c < 3; ++c) {
      const bool held = scene.supports.fixed(3 * static_cast<std::ptrdiff_t>(node) + c);
      if (held != scene.supports.fixed(3 * static_cast<std::ptrdiff_t>(images.nodes()[own]) + c))
        throw InvalidInput("Scene: symmetry: node " + std::to_string(node) + " at " +
                           place_text(scene.mesh.points.row(node)) + (held ? " is" : " is not") + " held along " +
                           "xyz"[c] + " as its mirror image " + (held ? "is not" : "is") +
                           "; must be alike. Leave symmetry out, or hold both.");
      if (held) part.fix(own, c);
    }
  }
  for (std::size_t plane = 0; plane < images.planes(); ++plane)
    for (std::int32_t own = 0; own < images.nodes().size(); ++own)
      if (images.partner(plane, images.nodes()[own]) == images.nodes()[own])
        part.fix(own, static_cast<int>(plane));
  return part;
}

}  // namespace

SymmetricPart::SymmetricPart(const Scene& scene)
    : images(known(scene).mesh, *scene.symmetry),
      mesh(images.part(scene.mesh)),
      tissue{scene.tissue.materials, scene.tissue.names, scene.tissue.cell_material(images.cells())},
      supports(supports_of(scene, images)) {
  require_symmetric_tissue(scene, images);
  const Points& x = scene.mesh.points;
  if (scene.mesh.stretched()) {
    constexpr double round_off = 1e-12;  // of the mesh's extent: a posture that moves no more has no symmetry
    const Points moved = x - scene.mesh.rest;
    const double extent = (x.colwise().maxCoeff() - x.colwise().minCoeff()).maxCoeff();
    if (moved.cwiseAbs().maxCoeff() > round_off * extent)
      images.require_symmetric_field(as_vector(moved), "the posture (m)", x);
  }
  if (scene.airflow)
    images.require_symmetric({flat_triangles(scene.mesh.surface(scene.airflow->surface))}, "the airflow's surface",
                             x);
  if (scene.contact)
    images.require_symmetric({scene.contact->airway.first, scene.contact->airway.second}, "the contact's surfaces",
                             x);
}

}  // namespace plica

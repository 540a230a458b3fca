#include "plica/dynamics/posture.hpp"

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/dynamics/rigid_motion.hpp"
#include "plica/dynamics/static_way.hpp"

namespace plica {

Posture stretched(const TetMesh& mesh, const Tissue& tissue, const Supports& supports, const HeldAt& held) {
  check_mesh(mesh);
  if (mesh.stretched()) throw InvalidInput("Posture: the mesh is stretched already; must be at rest.");
  tissue.validate(mesh);
  require_size("Posture", "supports", supports.size(), 3 * mesh.node_count());
  if (!rigid_motions(mesh, supports).empty())
    throw InvalidInput("Posture: the supports let tissue move without strain; must be held for a posture.");

  const Assembler assembler(mesh);
  Tissue pulling = tissue;
  StaticWay way;
  way.balance = [&](const Vector& u, double share) {
    for (std::size_t i = 0; i < tissue.materials.size(); ++i)
      pulling.materials[i].active_stress = share * tissue.materials[i].active_stress;
    return assembler.stretched(pulling, mesh.points + as_points(u));
  };
  way.moved = [&](double from, double to) -> Vector {
    const Points there = held(to), here = held(from);
    if (there.rows() != mesh.node_count() || here.rows() != there.rows())
      throw InvalidInput("Posture", "rows of what is held", static_cast<double>(there.rows()), "",
                         std::to_string(mesh.node_count()) + ", one a node");
    Vector all = as_vector(Points(there - here));
    if (!all.allFinite()) throw InvalidInput("Posture: where nodes are held is not finite; must be finite.");
    Vector free = all;
    supports.project(free);
    return all - free;
  };
  way.name = "Posture";
  way.of = "it";
  way.hint = "Take less of it, or tissue that is stiffer against it.";
  const StaticEnd end = walk(mesh, supports, way);
  return {as_points(end.displacement), end.parts, end.iterations};
}

}  // namespace plica

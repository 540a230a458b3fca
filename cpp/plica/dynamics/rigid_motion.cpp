#include "plica/dynamics/rigid_motion.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "plica/core/eigenpairs.hpp"
namespace plica {

namespace {

using Gram = Eigen::Matrix<double, 6, 6>;
using Twist = Eigen::Matrix<double, 6, 1>;  // a shift, then a turn about the body's centre times its size

/// The six motions of a body without strain as its held unknowns see them: singular where one of them is free.
std::optional<RigidMotion> rigid_motion(const TetMesh& mesh, const Supports& supports,
                                        const std::vector<std::int32_t>& nodes) {
  Vector3 centre = Vector3::Zero();
  for (const std::int32_t node : nodes) centre += mesh.points.row(node);
  centre /= static_cast<double>(nodes.size());
  double size = 0;
  for (const std::int32_t node : nodes) size = std::max(size, (mesh.points.row(node).transpose() - centre).norm());

  Gram held = Gram::Zero();
  for (const std::int32_t node : nodes)
    for (int d = 0; d < 3; ++d) {
      if (!supports.fixed(3 * static_cast<std::ptrdiff_t>(node) + d)) continue;
      const Vector3 arm = (mesh.points.row(node).transpose() - centre) / size;
      Twist seen;
      seen << Vector3::Unit(d), arm.cross(Vector3::Unit(d));
      held += seen * seen.transpose();
    }
  const Eigenpairs modes = symmetric_eigenpairs(held);
  if (modes.values[0] > 1e-12 * modes.values[5]) return std::nullopt;
  const Twist free = modes.vectors.col(0);
  const bool turns = free.tail<3>().norm() > 1e-6;
  return RigidMotion{nodes.front(), centre, turns, held.isZero(0),
                     (turns ? free.tail<3>() : free.head<3>()).normalized()};
}

}  // namespace

std::vector<RigidMotion> rigid_motions(const TetMesh& mesh, const Supports& supports) {
  const Indices body = body_of_nodes(mesh);
  std::vector<std::vector<std::int32_t>> members(static_cast<std::size_t>(body.size()));
  for (std::int32_t node = 0; node < body.size(); ++node)
    members[static_cast<std::size_t>(body[node])].push_back(node);
  std::vector<RigidMotion> found;
  for (const auto& nodes : members) {
    if (nodes.empty()) continue;
    if (const auto motion = rigid_motion(mesh, supports, nodes)) found.push_back(*motion);
  }
  return found;
}

}  // namespace plica

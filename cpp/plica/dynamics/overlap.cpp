#include "plica/dynamics/overlap.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <set>

#include "plica/mesh/tet_mesh.hpp"

namespace plica {
namespace {

using Face = std::array<std::int32_t, 3>;

Face face(std::int32_t a, std::int32_t b, std::int32_t c) {
  Face corners{a, b, c};
  std::sort(corners.begin(), corners.end());
  return corners;
}

}  // namespace

std::optional<std::int32_t> node_in_tissue(const Points& x, const Cells& cells, const Indices& nodes,
                                           double deep) {
  std::vector<std::int32_t> sorted(nodes.begin(), nodes.end());
  std::sort(sorted.begin(), sorted.end(), [&](std::int32_t a, std::int32_t b) { return x(a, 0) < x(b, 0); });
  std::set<Face> outer;
  const Boundary hull = boundary(cells);
  for (const auto& f : hull.faces.rowwise()) outer.insert(face(f[0], f[1], f[2]));

  for (std::ptrdiff_t c = 0; c < cells.rows(); ++c) {
    // A point on a face between two cells is as much inside as one off it.
    const auto least = [&](int k) {
      const Face opposite = face(cells(c, (k + 1) % 4), cells(c, (k + 2) % 4), cells(c, (k + 3) % 4));
      return outer.count(opposite) ? deep : -1e-9;
    };
    Eigen::Matrix<double, 4, 3> corners;
    for (int k = 0; k < 4; ++k) corners.row(k) = x.row(cells(c, k));
    const Eigen::RowVector3d low = corners.colwise().minCoeff(), high = corners.colwise().maxCoeff();
    const auto begin = std::lower_bound(sorted.begin(), sorted.end(), low[0],
                                        [&](std::int32_t node, double value) { return x(node, 0) < value; });
    for (auto node = begin; node != sorted.end() && x(*node, 0) <= high[0]; ++node) {
      const Eigen::RowVector3d p = x.row(*node);
      if ((p.array() < low.array()).any() || (p.array() > high.array()).any()) continue;
      const Matrix3 edges = (corners.bottomRows<3>().rowwise() - corners.row(0)).transpose();
      const Vector3 w = edges.inverse() * (p - corners.row(0)).transpose();
      const Eigen::Vector4d weights(1 - w.sum(), w[0], w[1], w[2]);
      bool inside = !(cells.row(c).array() == *node).any();
      for (int k = 0; k < 4 && inside; ++k) inside = weights[k] > least(k);
      if (inside) return *node;
    }
  }
  return std::nullopt;
}

}  // namespace plica

#include "plica/dynamics/overlap.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <set>

#include "plica/mesh/edges.hpp"
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

std::optional<std::int32_t> node_in_tissue(const Points& x, const Cells& cells, const Indices& nodes,
                                           double deep) {
  std::vector<std::int32_t> sorted(nodes.begin(), nodes.end());
  std::sort(sorted.begin(), sorted.end(), [&](std::int32_t a, std::int32_t b) { return x(a, 0) < x(b, 0); });
  std::set<FaceKey> outer_faces;
  std::set<Edge> outer_edges;
  std::set<std::int32_t> outer_nodes;
  const Boundary hull = boundary(cells);
  for (const auto& f : hull.faces.rowwise()) {
    outer_faces.insert(face_key(f[0], f[1], f[2]));
    for (int k = 0; k < 3; ++k) {
      outer_edges.insert(edge(f[k], f[(k + 1) % 3]));
      outer_nodes.insert(f[k]);
    }
  }

  for (std::ptrdiff_t c = 0; c < cells.rows(); ++c) {
    // Away from the tissue's boundary by `deep` of the cell: from each outer face, edge and corner that it has. A
    // point on a face between two cells is as much inside as one off it.
    const auto clear = [&](const Eigen::Vector4d& weights) {
      for (int k = 0; k < 4; ++k) {
        const std::int32_t node = cells(c, k);
        const FaceKey opposite = face_key(cells(c, (k + 1) % 4), cells(c, (k + 2) % 4), cells(c, (k + 3) % 4));
        if (!(weights[k] > (outer_faces.count(opposite) ? deep : -1e-9))) return false;
        if (outer_nodes.count(node) && !(1 - weights[k] > deep)) return false;
        for (int l = 0; l < k; ++l)
          if (outer_edges.count(edge(node, cells(c, l))) && !(1 - weights[k] - weights[l] > deep)) return false;
      }
      return true;
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
      if (!(cells.row(c).array() == *node).any() && clear(weights)) return *node;
    }
  }
  return std::nullopt;
}

}  // namespace plica

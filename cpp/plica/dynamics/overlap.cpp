#include "plica/dynamics/overlap.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace plica {

std::optional<std::int32_t> node_in_tissue(const Points& x, const Cells& cells, const Indices& nodes,
                                           double deep) {
  std::vector<std::int32_t> sorted(nodes.begin(), nodes.end());
  std::sort(sorted.begin(), sorted.end(), [&](std::int32_t a, std::int32_t b) { return x(a, 0) < x(b, 0); });
  for (std::ptrdiff_t c = 0; c < cells.rows(); ++c) {
    Eigen::Matrix<double, 4, 3> corners;
    for (int k = 0; k < 4; ++k) corners.row(k) = x.row(cells(c, k));
    const Eigen::RowVector3d low = corners.colwise().minCoeff(), high = corners.colwise().maxCoeff();
    const auto begin = std::lower_bound(sorted.begin(), sorted.end(), low[0],
                                        [&](std::int32_t node, double value) { return x(node, 0) < value; });
    for (auto node = begin; node != sorted.end() && x(*node, 0) <= high[0]; ++node) {
      const Eigen::RowVector3d p = x.row(*node);
      if ((p.array() < low.array()).any() || (p.array() > high.array()).any()) continue;
      const Matrix3 edges = (corners.bottomRows<3>().rowwise() - corners.row(0)).transpose();
      const Vector3 weights = edges.inverse() * (p - corners.row(0)).transpose();
      if (weights.minCoeff() > deep && weights.sum() < 1 - deep) return *node;
    }
  }
  return std::nullopt;
}

}  // namespace plica

#include "plica/mesh/jacobian.hpp"

#include <Eigen/Dense>
#include <array>
#include <limits>

#include "plica/core/require.hpp"
#include "plica/mesh/edges.hpp"
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

Vector least_jacobian_ratios(const Points& x, const Cells& cells) {
  require_size("least_jacobian_ratios", "a cell", cells.cols(), 4, 10);
  require_indices("least_jacobian_ratios", "node of a cell", cells, x.rows());
  Vector ratios = Vector::Ones(cells.rows());
  if (cells.cols() != 10) return ratios;
  const Vector volumes = signed_volumes(x, cells);
  for (Eigen::Index e = 0; e < cells.rows(); ++e) {
    // With x = sum L_i L_j b_ij (b_ii corners, b_ij = 2 m_ij - (x_i + x_j) / 2) the columns of dx/dxi are
    // 2 sum_i L_i g_i,c with g_i,c = b_i,c+1 - b_i0, and det is a cubic whose coefficient of the Bernstein
    // polynomial (i, j, k) is the mean of det over the orders in which i, j, k may stand.
    std::array<std::array<Vector3, 4>, 4> b;
    for (int i = 0; i < 4; ++i) b[i][i] = x.row(cells(e, i));
    for (int m = 0; m < 6; ++m) {
      const auto [i, j] = tet_edges[m];
      b[i][j] = b[j][i] = 2 * x.row(cells(e, 4 + m)).transpose() - 0.5 * (b[i][i] + b[j][j]);
    }
    std::array<std::array<Vector3, 3>, 4> g;
    for (int i = 0; i < 4; ++i)
      for (int c = 0; c < 3; ++c) g[i][c] = 2 * (b[i][c + 1] - b[i][0]);
    const auto det = [&](int i, int j, int k) { return g[i][0].dot(g[j][1].cross(g[k][2])); };
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 4; ++i)
      for (int j = i; j < 4; ++j)
        for (int k = j; k < 4; ++k)
          least = std::min(
              least,
              (det(i, j, k) + det(i, k, j) + det(j, i, k) + det(j, k, i) + det(k, i, j) + det(k, j, i)) / 6);
    ratios[e] = least / (6 * volumes[e]);
  }
  return ratios;
}

}  // namespace plica

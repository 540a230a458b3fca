#include <Eigen/Dense>
#include <algorithm>
#include <atomic>

#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"
#include "plica/mesh/edges.hpp"
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

namespace {

/// As jacobian_at_node, unchecked.
double jacobian(const Points& x, const Cells& cells, Eigen::Index e, int k) {
  Eigen::Vector4d L = Eigen::Vector4d::Zero();  // barycentric coordinates of the node
  if (k < 4) {
    L[k] = 1;
  } else {
    for (const int corner : tet_edges[k - 4]) L[corner] = 0.5;
  }
  // dx/dL_i for independent L: corners N = L (2 L - 1), mid-side nodes N = 4 L_a L_b; linear: N = L.
  const bool quadratic = cells.cols() == 10;
  Eigen::Matrix<double, 4, 3> d;
  for (int i = 0; i < 4; ++i) d.row(i) = (quadratic ? 4 * L[i] - 1 : 1.0) * x.row(cells(e, i));
  for (int i = 0; quadratic && i < 6; ++i) {
    const auto [a, b] = tet_edges[i];
    d.row(a) += 4 * L[b] * x.row(cells(e, 4 + i));
    d.row(b) += 4 * L[a] * x.row(cells(e, 4 + i));
  }
  Matrix3 columns;
  for (int i = 0; i < 3; ++i) columns.col(i) = (d.row(i + 1) - d.row(0)).transpose();
  return columns.determinant();
}

bool folded(const Points& x, const Cells& cells, Eigen::Index e) {
  const int places = cells.cols() == 10 ? 10 : 1;  // constant in a linear cell
  for (int k = 0; k < places; ++k)
    if (!(jacobian(x, cells, e, k) > 0)) return true;
  return false;
}

}  // namespace

Vector signed_volumes(const Points& x, const Cells& cells) {
  require_size("signed_volumes", "a cell", cells.cols(), 4, 10);
  require_indices("signed_volumes", "node of a cell", cells, x.rows());
  Vector volumes(cells.rows());
  for (Eigen::Index e = 0; e < cells.rows(); ++e) {
    const Vector3 origin = x.row(cells(e, 0));
    const Vector3 a = x.row(cells(e, 1)).transpose() - origin;
    const Vector3 b = x.row(cells(e, 2)).transpose() - origin;
    const Vector3 c = x.row(cells(e, 3)).transpose() - origin;
    volumes[e] = a.cross(b).dot(c) / 6;
  }
  return volumes;
}

double jacobian_at_node(const Points& x, const Cells& cells, Eigen::Index e, int k) {
  require_size("jacobian_at_node", "a cell", cells.cols(), 4, 10);
  require_index("jacobian_at_node", "cell", e, cells.rows());
  require_index("jacobian_at_node", "node of the cell", k, cells.cols());
  for (Eigen::Index i = 0; i < cells.cols(); ++i) require_index("jacobian_at_node", "node", cells(e, i), x.rows());
  return jacobian(x, cells, e, k);
}

std::ptrdiff_t folded_cells(const Points& x, const Cells& cells) {
  require_size("folded_cells", "a cell", cells.cols(), 4, 10);
  require_indices("folded_cells", "node of a cell", cells, x.rows());
  std::atomic<std::ptrdiff_t> count = 0;
  for_chunks(cells.rows(), 1024, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    for (std::ptrdiff_t e = begin; e < end; ++e)
      if (folded(x, cells, e)) ++count;
  });
  return count;
}

std::ptrdiff_t folded_cells(const Points& x, const Cells& cells, const std::vector<std::int32_t>& suspects) {
  require_size("folded_cells", "a cell", cells.cols(), 4, 10);
  for (const std::int32_t e : suspects) {
    require_index("folded_cells", "suspect", e, cells.rows());
    for (Eigen::Index i = 0; i < cells.cols(); ++i) require_index("folded_cells", "node", cells(e, i), x.rows());
  }
  return std::count_if(suspects.begin(), suspects.end(), [&](std::int32_t e) { return folded(x, cells, e); });
}

std::optional<std::ptrdiff_t> first_folded_cell(const Points& x, const Cells& cells) {
  require_size("first_folded_cell", "a cell", cells.cols(), 4, 10);
  require_indices("first_folded_cell", "node of a cell", cells, x.rows());
  for (std::ptrdiff_t e = 0; e < cells.rows(); ++e)
    if (folded(x, cells, e)) return e;
  return std::nullopt;
}

}  // namespace plica

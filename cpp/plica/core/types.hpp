#pragma once
// The arrays that every module speaks in. All are dense, row-major and SI.
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "plica/core/abi.hpp"
#include "plica/core/error.hpp"
#include "plica/core/require.hpp"

namespace plica {

using Vector = Eigen::VectorXd;
using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
/// (n, 3) positions, displacements, forces, ...; its memory is the interleaved (3 n) vector.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Indices = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 1>;
/// (m, 4) or (m, 10) rows of node numbers, VTK order.
using Cells = Eigen::Matrix<std::int32_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
/// (f, 3) or (f, 6) rows of node numbers, VTK order, counter-clockwise seen from outside the tissue.
using Faces = Eigen::Matrix<std::int32_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Triangles = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Tets = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 4, Eigen::RowMajor>;

/// A vector at a node of the mesh.
struct NodeVector {
  std::int32_t node;
  Vector3 vector;
};

/// "(1, -0.5, 0) m".
std::string place_text(const Vector3& x);

/// The (n, 3) view of an interleaved nodal vector (3 n), and back.
inline Eigen::Map<const Points> as_points(const Vector& v) {
  require_rows("as_points", "v", v.size(), 3);
  return {v.data(), v.size() / 3, 3};
}
inline Eigen::Map<Points> as_points(Vector& v) {
  require_rows("as_points", "v", v.size(), 3);
  return {v.data(), v.size() / 3, 3};
}
inline Eigen::Map<const Vector> as_vector(const Points& p) { return {p.data(), p.size()}; }

}  // namespace plica

#pragma once
// How the cells of a mesh are stretched, and where that is looked at.
#include "plica/mesh/tet_mesh.hpp"
#include "plica/tissue/element.hpp"

namespace plica {

/// Where its mass was measured.
inline const Points& at_rest(const TetMesh& mesh) { return mesh.stretched() ? mesh.rest : mesh.points; }

/// Where a cell is looked at, and for which share of its volume: once where its strain is the same everywhere.
inline const TetrahedronRule& rule_of(const TetMesh& mesh) {
  static const TetrahedronRule middle{{{0.25, 0.25, 0.25, 0.25}, 1.0}};
  return mesh.order() == 1 ? middle : tetrahedron_rule_degree_5();
}

using Gradients = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// dx/dX of a cell whose nodes are at x.
inline Matrix3 deformation(const Points& x, const std::int32_t* cell, const Gradients& gradients) {
  Matrix3 F = Matrix3::Zero();
  for (std::ptrdiff_t a = 0; a < gradients.rows(); ++a) F += x.row(cell[a]).transpose() * gradients.row(a);
  return F;
}

/// (6, 3) d(engineering strain)/d(node's place), g its shape function's gradient at rest.
inline Eigen::Matrix<double, 6, 3> strain_slope(const Matrix3& F, const Vector3& g) {
  Eigen::Matrix<double, 6, 3> B;
  for (int k = 0; k < 3; ++k)
    B.col(k) << F(k, 0) * g[0], F(k, 1) * g[1], F(k, 2) * g[2], F(k, 0) * g[1] + F(k, 1) * g[0],
        F(k, 1) * g[2] + F(k, 2) * g[1], F(k, 2) * g[0] + F(k, 0) * g[2];
  return B;
}

}  // namespace plica

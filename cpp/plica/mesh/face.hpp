#pragma once
#include <array>

#include "plica/mesh/tet_mesh.hpp"

namespace plica {

/// A value for each node of a face, 3 or 6.
using FaceScalars = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;

/// Shape functions of a face at (r, s), corners (0, 0), (1, 0), (0, 1), and their derivatives along both.
struct FaceShapes {
  FaceScalars value, along_r, along_s;
};
/// nodes: 3 or 6, as in Faces.
FaceShapes face_shapes(Eigen::Index nodes, double r, double s);

/// How many flat triangles flat_triangles makes of a face with that many nodes, and the corners (r, s) of the
/// k-th.
inline int triangles_of_face(Eigen::Index nodes) { return nodes == 6 ? 4 : 1; }
using ParameterTriangle = std::array<Eigen::Vector2d, 3>;
const ParameterTriangle& parameter_triangle(Eigen::Index nodes, int k);

}  // namespace plica

#pragma once
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include "plica/contact/surface.hpp"

/// A second algorithm for detection, by brute force.
namespace oracle {

using namespace plica;

/// Whether p lies in one of the linear cells at positions x; a face between two cells belongs to both.
inline bool in_tissue(const Points& x, const Cells& cells, const Vector3& p) {
  constexpr double slack = 1e-9;  // of barycentric coordinates, for points on such a face
  for (const auto& cell : cells.rowwise()) {
    const Vector3 origin = x.row(cell[0]);
    Matrix3 edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = x.row(cell[k + 1]).transpose() - origin;
    const Vector3 weights = edges.inverse() * (p - origin);
    if (weights.minCoeff() >= -slack && weights.sum() <= 1 + slack) return true;
  }
  return false;
}

inline double distance(const Points& x, const Triangles& surface, const Vector3& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& t : surface.rowwise()) {
    const Vector3 a = x.row(t[0]), b = x.row(t[1]), c = x.row(t[2]), w = closest_weights(p, a, b, c);
    least = std::min(least, (p - w[0] * a - w[1] * b - w[2] * c).norm());
  }
  return least;
}

/// Distance of a point to the open border of a surface, where its tissue turns away from the other body.
inline double distance_to_rim(const Points& x, const Triangles& surface, const Vector3& p) {
  std::map<std::array<std::int32_t, 2>, int> faces;
  for (const auto& t : surface.rowwise())
    for (int k = 0; k < 3; ++k) ++faces[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [edge, count] : faces) {
    if (count > 1) continue;
    const Vector3 a = x.row(edge[0]), along = x.row(edge[1]).transpose() - a;
    const double t = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (p - a - t * along).norm());
  }
  return least;
}

}  // namespace oracle

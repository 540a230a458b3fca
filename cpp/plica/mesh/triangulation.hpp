#pragma once
#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "plica/mesh/edges.hpp"

namespace plica {

/// Points of the plane and counter-clockwise triangles of them.
struct Triangulation {
  std::vector<Eigen::Vector2d> points;
  std::vector<std::array<std::int32_t, 3>> triangles;
};

/// What is to be triangulated: points, and polylines through them whose pieces become edges. Lines meet in points
/// only. No triangle has its three corners on one line, where the outline lets it.
struct Outline {
  std::vector<Eigen::Vector2d> points;
  std::vector<std::vector<std::int32_t>> lines;
  std::function<bool(const Eigen::Vector2d&)> inside;  // of points off the segments
  std::function<double(const Eigen::Vector2d&)> size;  // wanted length of edges, > 0
};

/// The constrained Delaunay triangulation of the outline, with points added inside at circumcentres until no
/// triangle is larger than the wanted size, then moved to the middle of their neighbours. The points of the
/// outline come first, in its order; the pieces of lines are not divided. Deterministic. O(n^2), for sections of
/// some thousand points.
Triangulation triangulate(const Outline& outline);

}  // namespace plica

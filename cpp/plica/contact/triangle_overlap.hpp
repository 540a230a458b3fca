#pragma once
#include <array>
#include <vector>

#include "plica/core/types.hpp"

namespace plica {

/// A point of a triangle by its coordinates (r, s) along the sides from corner 0, and its share of an integral.
struct TrianglePoint {
  Eigen::Vector2d place;
  double weight;  // of dr ds
};

/// The corners of `other`, seen along the normal of `triangle`, in its coordinates (r, s).
std::array<Eigen::Vector2d, 3> seen_from(const std::array<Vector3, 3>& triangle,
                                         const std::array<Vector3, 3>& other);

/// Quadrature points, exact to degree 4, over what the triangle (0, 0), (1, 0), (0, 1) shares with one that is
/// clockwise in its coordinates, as one that faces it is. Empty where they share nothing, or for the other sense.
std::vector<TrianglePoint> overlap_points(const std::array<Eigen::Vector2d, 3>& other);

}  // namespace plica

#pragma once
#include <optional>

#include "plica/contact/triangle_tree.hpp"
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

/// The point of a triangulated surface that is closest to some other point.
struct Foot {
  std::int32_t triangle = -1;
  Vector3 weights = Vector3::Zero();  // barycentric, >= 0, sum 1
  double squared_distance = 0.0;      // m^2
};

/// One side of a contact: triangles with their neighbours, and the normals and areas of the current shape.
class ContactSurface {
 public:
  /// triangles (f, 3) outward; node_count of the whole mesh. Throws InvalidInput where it is empty.
  ContactSurface(Triangles triangles, std::ptrdiff_t node_count);

  const Triangles& triangles() const { return triangles_; }
  const std::vector<std::int32_t>& nodes() const { return nodes_; }
  bool contains(std::int32_t node) const { return local_[static_cast<std::size_t>(node)] >= 0; }
  /// The triangles around this node.
  Eigen::Map<const Indices> fan(std::int32_t node) const;
  /// Mean edge length at positions x, m.
  double mean_edge(const Points& x) const;

  /// Looks from the next update on at these triangles (numbers, ascending) alone: what follows is then known of
  /// nodes that have no others, and closest points are those of these triangles.
  void look_at(std::vector<std::int32_t> triangles);
  void look_everywhere();
  /// Whether a triangle looked at has a corner with others: what is known there is not all.
  bool on_rim(std::int32_t triangle) const { return rim_[static_cast<std::size_t>(triangle)] != 0; }

  /// Takes up positions x: normals at the nodes (area-weighted, unit), tributary areas (a third of each triangle).
  /// O(n) of the triangles looked at.
  void update(const Points& x);
  const Vector3& normal(std::int32_t node) const;
  double tributary_area(std::int32_t node) const;
  /// How far (m) the triangles around a node leave the plane across its normal at x, positions of the last update.
  double bulge(std::int32_t node, const Points& x) const;
  /// The stretch of y (m, m) that a node stands for: half the way to the least and to the largest y of its
  /// triangles.
  std::pair<double, double> tributary_stretch(std::int32_t node, const Points& x) const;
  /// Unit normal at a foot: the node normals, interpolated. Continuous over the surface.
  Vector3 normal(const Foot& foot) const;

  /// The closest point of all to p, at x, the positions of the last update; of several as close, that of the first
  /// triangle. O(log f) in practice.
  /// `near`: number of a triangle that may be near it, or -1; what is found does not depend on it.
  Foot closest(const Points& x, const Vector3& p, std::int32_t near = -1) const;
  /// Whether it comes as near to p as this (m) at x, the positions of the last update.
  bool within(const Points& x, const Vector3& p, double distance) const;

 private:
  Foot foot_on(const Points& x, const Vector3& p, std::int32_t triangle) const;

  Triangles triangles_;
  std::vector<std::int32_t> nodes_;            // ascending
  std::vector<std::int32_t> local_;            // node of the mesh -> position in nodes_, or -1
  std::vector<std::int32_t> fan_start_, fan_;  // triangles around each local node
  std::vector<Vector3> normals_;
  std::vector<double> areas_;
  std::vector<std::int32_t> shown_, shown_nodes_;  // triangles looked at, and their places in nodes_
  std::vector<char> is_shown_, rim_;               // of all triangles
  std::optional<TriangleTree> tree_;               // of these, from the first update on
};

/// Barycentric weights of the point of triangle (a, b, c) closest to p.
Vector3 closest_weights(const Vector3& p, const Vector3& a, const Vector3& b, const Vector3& c);

}  // namespace plica

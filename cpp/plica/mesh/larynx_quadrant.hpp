#pragma once
// One quadrant of the triangulated larynx, which mirrored makes the whole.

#include <cmath>

#include "plica/mesh/larynx_section.hpp"
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

/// One quadrant, x, y >= 0: lines 0 (y = 0) to `lines` (the tip), a node at each vertex and line.
struct LarynxQuadrant {
  const Larynx::Shape& shape;
  HalfSection section;
  int lines;
  double tip_cut;  // Larynx::Triangulated
  TetMesh mesh;    // points and cells

  std::int32_t node(std::int32_t vertex, int line) const { return vertex * (lines + 1) + line; }
  int line(std::int32_t node) const { return node % (lines + 1); }
  const SectionVertex& vertex(std::int32_t node) const {
    return section.vertices[static_cast<std::size_t>(node / (lines + 1))];
  }
  /// cos and sin of the angle at which a line, or the middle between two, lies; exact at both ends.
  Eigen::Vector2d direction(double line) const {
    if (line == 0) return {1, 0};
    if (line == lines) return {0, 1};
    const double angle = std::acos(0.0) * line / lines;
    return {std::cos(angle), std::sin(angle)};
  }
  Eigen::Vector2d ellipse(double minor, double line) const {
    const Eigen::Vector2d d = direction(line);
    return {minor * d[0], shape.major * d[1]};
  }
  Eigen::Vector2d cylinder(double line) const { return shape.radius * direction(line); }
  /// Whether the tip, what lies behind it and the next line of the airway are nearly in a line, at a vertex of the
  /// airway: where the glottis is narrow.
  bool narrow(std::int32_t vertex) const {
    const SectionVertex& own = section.vertices[static_cast<std::size_t>(vertex)];
    const Eigen::Vector2d next = direction(lines - 1);
    return own.airway && own.minor * next[0] < tip_cut * shape.major * (1 - next[1]);
  }
  /// Quads of even and odd lines are cut by turns: at the lower vertex on even lines. Those that begin at the tip
  /// of a narrow glottis are cut there, as the other triangles would be flat.
  std::int64_t key(std::int32_t vertex, int line) const {
    const auto count = static_cast<std::int64_t>(section.vertices.size());
    if (line == lines && narrow(vertex)) return vertex - count;
    return line % 2 == 0 ? vertex : 2 * count - vertex;
  }
};

/// Carries the half section around the airway, and smooths the nodes that may move. Throws InvalidInput where a
/// tetrahedron is left inside out.
LarynxQuadrant larynx_quadrant(const Larynx::Shape& shape, const Larynx::Triangulated& how);

}  // namespace plica

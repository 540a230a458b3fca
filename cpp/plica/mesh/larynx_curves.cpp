#include "plica/mesh/larynx_curves.hpp"

#include <Eigen/Dense>
#include <algorithm>

#include "plica/mesh/jacobian.hpp"

namespace plica {

namespace {

using Plane = Eigen::Vector2d;

LarynxCurves bent(const LarynxQuadrant& q) {
  LarynxCurves made;
  made.edges = unique_edges(q.mesh.cells);
  for (const auto& [a, b] : made.edges) {
    const SectionVertex &v = q.vertex(a), &w = q.vertex(b);
    const double la = q.line(a), lb = q.line(b), line = 0.5 * (la + lb), minor = 0.5 * (v.minor + w.minor);
    const std::int32_t va = a / (q.lines + 1), vb = b / (q.lines + 1);
    const bool airway =
        v.airway && w.airway &&
        (va == vb || std::binary_search(q.section.airway.begin(), q.section.airway.end(), edge(va, vb)));
    const bool wall = v.wall && w.wall;
    const Plane chord = 0.5 * (q.mesh.points.row(a) + q.mesh.points.row(b)).head<2>().transpose();
    Plane bend = Plane::Zero();
    if (airway) {
      if (la != lb) bend = q.ellipse(minor, line) - chord;
    } else if (wall) {
      if (la != lb) bend = q.shape.radius / chord.norm() * chord - chord;
    } else if (la != lb) {
      const Plane inner = q.ellipse(minor, line) - 0.5 * (q.ellipse(v.minor, la) + q.ellipse(w.minor, lb));
      const Plane outer = q.cylinder(line) - 0.5 * (q.cylinder(la) + q.cylinder(lb));
      const auto deep = [&](std::int32_t node, const SectionVertex& own, double at) {
        const Plane from = q.ellipse(own.minor, at), to = q.cylinder(at), along = to - from;
        const Plane p = q.mesh.points.row(node).head<2>();
        return std::clamp((p - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
      };
      const double depth = 0.5 * (deep(a, v, la) + deep(b, w, lb));
      bend = (1 - depth) * inner + depth * outer;
    }
    made.bend.emplace_back(bend[0], bend[1], 0);
    made.surface.push_back(airway || wall);
  }
  return made;
}

/// Straightens sides until no cell's det dx/dxi falls anywhere below `least_jacobian` times the straight cell's:
/// sides inside first.
void straighten(const LarynxQuadrant& q, LarynxCurves& curves) {
  constexpr double least_jacobian = 0.1;
  TetMesh bare;
  bare.points = q.mesh.points;
  bare.cells = q.mesh.cells;
  TetMesh mesh = to_quadratic(bare);
  const Eigen::Index corners = q.mesh.points.rows();
  const Points straight = mesh.points.bottomRows(mesh.points.rows() - corners);
  for (int pass = 0; pass < 40; ++pass) {
    for (std::size_t i = 0; i < curves.bend.size(); ++i)
      mesh.points.row(corners + static_cast<Eigen::Index>(i)) =
          straight.row(static_cast<Eigen::Index>(i)) + curves.bend[i].transpose();
    const Vector ratio = least_jacobian_ratios(mesh.points, mesh.cells);
    std::vector<char> suffers(curves.bend.size(), 0);
    for (Eigen::Index e = 0; e < mesh.cells.rows(); ++e) {
      if (ratio[e] >= least_jacobian) continue;
      for (int k = 4; k < 10; ++k) suffers[mesh.cells(e, k) - corners] = 1;
    }
    bool changed = false;
    for (std::size_t i = 0; i < suffers.size(); ++i)
      if (suffers[i] && (pass >= 8 || !curves.surface[i])) curves.bend[i] *= pass < 30 ? 0.5 : 0.0;
    for (const char one : suffers) changed |= one;
    if (!changed) return;
  }
}

}  // namespace

LarynxCurves larynx_curves(const LarynxQuadrant& quadrant) {
  LarynxCurves made = bent(quadrant);
  straighten(quadrant, made);
  return made;
}

}  // namespace plica

#include "plica/meshing/triangulated_airway.hpp"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <random>
#include <string>
#include <utility>

#include "plica/contact/surface.hpp"
#include "plica/core/error.hpp"

namespace plica {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Triangulation_vertex_base_with_info_3<std::int32_t, Kernel>;
using Structure = CGAL::Triangulation_data_structure_3<Vertex, CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, Structure>;
using Tet = std::array<std::int32_t, 4>;

/// Whether a tetrahedron, positive at x, has nodes of both surfaces and lies in the air between them: from the
/// first side's nodes to the second's, across the face or the edges between them, goes the way the normals point.
bool in_air(const Tet& tet, const Points& x, const ContactSurface& first, const ContactSurface& second) {
  Tet own{}, other{};
  int n_own = 0, n_other = 0;
  Vector3 outward = Vector3::Zero();  // from the first surface to the second
  for (const std::int32_t node : tet) {
    const bool f = first.contains(node), s = second.contains(node);
    if (f && !s) own[n_own++] = node, outward += first.normal(node);
    if (s && !f) other[n_other++] = node, outward -= second.normal(node);
  }
  if (n_own == 0 || n_other == 0) return false;
  const auto at = [&](std::int32_t node) -> Vector3 { return x.row(node); };
  Vector3 across = at(other[0]) - at(own[0]);
  if (n_own == 2 && n_other == 2) across = (at(own[1]) - at(own[0])).cross(at(other[1]) - at(other[0]));
  if (n_own == 3) across = (at(own[1]) - at(own[0])).cross(at(own[2]) - at(own[0]));
  if (n_other == 3) across = (at(other[1]) - at(other[0])).cross(at(other[2]) - at(other[0]));
  if (across.dot(at(other[0]) - at(own[0])) < 0) across = -across;
  return across.dot(outward) > 0;
}

/// Moves the nodes of `side` that `other` lacks back along their normals, by half the depth and a tenth of the
/// shortest edge around each.
void shrink(const ContactSurface& side, const ContactSurface& other, const Points& x, double depth, Points& y) {
  Vector shortest = Vector::Constant(x.rows(), std::numeric_limits<double>::infinity());
  for (const auto& t : side.triangles().rowwise())
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = t[k], b = t[(k + 1) % 3];
      const double length = (x.row(a) - x.row(b)).norm();
      shortest[a] = std::min(shortest[a], length);
      shortest[b] = std::min(shortest[b], length);
    }
  for (const std::int32_t node : side.nodes())
    if (!other.contains(node)) y.row(node) -= (0.5 * depth + 0.1 * shortest[node]) * side.normal(node);
}

/// Positions at which both bodies are shrunk: what touches, lies flat on each other or overlaps by `depth` is then
/// as far apart as a good tetrahedron needs. All are shifted by some 1e-4 mean edges, the same each time: of the
/// points of structured meshes, many lie on one sphere, which costs exact arithmetic some five times as long.
Points apart(const Points& x, const ContactSurface& first, const ContactSurface& second, double depth) {
  Points y = x;
  shrink(first, second, x, depth, y);
  shrink(second, first, x, depth, y);
  const double shift = 1e-4 * std::min(first.mean_edge(x), second.mean_edge(x));
  std::mt19937 random;
  for (const auto* side : {&first, &second})
    for (const std::int32_t node : side->nodes())
      for (int d = 0; d < 3; ++d) y(node, d) += shift * (random() / 4294967296.0 - 0.5);
  return y;
}

Tets air(const Points& x, const ContactSurface& first, const ContactSurface& second, double depth) {
  const Points y = apart(x, first, second, depth);
  std::vector<std::pair<Kernel::Point_3, std::int32_t>> points;
  const auto add = [&](std::int32_t node) {
    points.emplace_back(Kernel::Point_3(y(node, 0), y(node, 1), y(node, 2)), node);
  };
  for (const std::int32_t node : first.nodes()) add(node);
  for (const std::int32_t node : second.nodes())
    if (!first.contains(node)) add(node);

  const Delaunay delaunay(points.begin(), points.end());
  std::vector<Tet> tets;
  for (const auto cell : delaunay.finite_cell_handles()) {
    Tet tet{};
    for (int k = 0; k < 4; ++k) tet[k] = cell->vertex(k)->info();
    if (in_air(tet, y, first, second)) tets.push_back(tet);
  }
  std::sort(tets.begin(), tets.end());  // the same order however CGAL came to them
  Tets found(static_cast<std::ptrdiff_t>(tets.size()), 4);
  for (std::size_t t = 0; t < tets.size(); ++t)
    for (int k = 0; k < 4; ++k) found(static_cast<std::ptrdiff_t>(t), k) = tets[t][k];
  return found;
}

}  // namespace

Airway triangulated_airway(const Points& points, const Triangles& first, const Triangles& second) {
  ContactSurface a(first, points.rows()), b(second, points.rows());
  for (const ContactSurface* side : {&a, &b})
    for (const std::int32_t node : side->nodes())
      if (!points.row(node).allFinite())
        throw InvalidInput("triangulated_airway: position of node " + std::to_string(node) +
                           " is not finite; must be finite.");
  a.update(points);
  b.update(points);
  Airway airway{first, second, air(points, a, b, 0.0), &air};
  if (airway.tets.rows() == 0)
    throw InvalidInput("triangulated_airway", "tetrahedra of air", 0, "", "> 0",
                       "Do the two surfaces face each other?");
  return airway;
}

}  // namespace plica

#include "plica/contact/airway.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <unordered_map>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"

namespace plica {
namespace {

using Triangle = std::array<std::int32_t, 3>;

std::vector<std::int32_t> nodes_of(const Triangles& triangles) {
  std::vector<std::int32_t> nodes(triangles.data(), triangles.data() + triangles.size());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

double extent_of(const Points& points, const std::vector<std::int32_t>& nodes) {
  Vector3 low = points.row(nodes[0]).transpose(), high = low;
  for (const auto node : nodes) {
    if (!points.row(node).allFinite()) return std::numeric_limits<double>::quiet_NaN();
    low = low.cwiseMin(points.row(node).transpose());
    high = high.cwiseMax(points.row(node).transpose());
  }
  return (high - low).norm();
}

/// Nodes hashed by their position across a direction, in square cells twice the tolerance wide.
class AcrossGrid {
 public:
  AcrossGrid(const Points& points, const std::vector<std::int32_t>& nodes, const Vector3& direction,
             double tolerance)
      : points_(points), tolerance_(tolerance), u_(direction.unitOrthogonal()), v_(direction.cross(u_)) {
    for (const auto node : nodes) {
      const auto [i, j] = cell(position(node));
      cells_[key(i, j)].push_back(node);
    }
  }

  /// Nodes of the grid at the position of `node` across the direction.
  std::vector<std::int32_t> facing(std::int32_t node) const {
    const Eigen::Vector2d p = position(node);
    const auto [i, j] = cell(p);
    std::vector<std::int32_t> found;
    for (std::int64_t a = i - 1; a <= i + 1; ++a)
      for (std::int64_t b = j - 1; b <= j + 1; ++b) {
        const auto at = cells_.find(key(a, b));
        if (at == cells_.end()) continue;
        for (const auto other : at->second)
          if ((position(other) - p).norm() <= tolerance_) found.push_back(other);
      }
    return found;
  }

 private:
  Eigen::Vector2d position(std::int32_t node) const {
    const Vector3 p = points_.row(node).transpose();
    return {p.dot(u_), p.dot(v_)};
  }
  std::array<std::int64_t, 2> cell(const Eigen::Vector2d& p) const {
    return {static_cast<std::int64_t>(std::floor(p[0] / (2 * tolerance_))),
            static_cast<std::int64_t>(std::floor(p[1] / (2 * tolerance_)))};
  }
  static std::int64_t key(std::int64_t i, std::int64_t j) { return i * 2147483647 + j; }

  const Points& points_;
  double tolerance_;
  Vector3 u_, v_;
  std::unordered_map<std::int64_t, std::vector<std::int32_t>> cells_;
};

/// The node of `grid` that faces each of `nodes`.
std::unordered_map<std::int32_t, std::int32_t> partners(const Points& points,
                                                        const std::vector<std::int32_t>& nodes,
                                                        const AcrossGrid& grid, const std::string& own,
                                                        const std::string& other) {
  std::unordered_map<std::int32_t, std::int32_t> partner;
  for (const auto node : nodes) {
    const auto found = grid.facing(node);
    if (found.size() != 1)
      throw InvalidInput("matched_airway: node " + std::to_string(node) + " of " + own + " = " +
                         place_text(points.row(node).transpose()) + "; must have one partner in " + other +
                         " at the same position across the direction, has " + std::to_string(found.size()) +
                         ". Do the two surfaces face each other everywhere?");
    partner[node] = found[0];
  }
  return partner;
}

/// The same triangle, same sense, smallest node first.
Triangle from_smallest(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

/// Tetrahedra of the prism from triangle a to its partner b. Each quadrilateral is cut from the end of smaller
/// node number in a to the other end in b, a rule that neighbours share. Positive where b lies on the side that
/// a's normal points to: signs come from the sense of a alone, never from the volumes, which are zero at contact.
/// With b above a the three volumes are a third of a's projected area times the gap at one node each, and the
/// one of a closed node (a_i = b_i) is left out.
void cut_prism(const Triangle& a, const Triangle& b, std::vector<std::int32_t>& tets) {
  std::array<int, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int i, int j) { return a[i] < a[j]; });
  const auto [i, j, k] = order;
  const bool odd = (j - i + 3) % 3 == 2;
  std::array<std::array<std::int32_t, 4>, 3> cut{
      {{a[i], a[j], a[k], b[k]}, {a[i], a[j], b[k], b[j]}, {a[i], b[i], b[j], b[k]}}};
  const std::array<int, 3> gap{k, j, i};
  for (int t = 0; t < 3; ++t) {
    if (a[gap[t]] == b[gap[t]]) continue;
    if (odd) std::swap(cut[t][2], cut[t][3]);
    tets.insert(tets.end(), cut[t].begin(), cut[t].end());
  }
}

/// Whether a tetrahedron is turned inside out, exactly: by its volume where this is far from what rounding could
/// make of a flat one, by CGAL's predicate otherwise.
bool is_inverted(const Points& x, const Eigen::Matrix<std::int32_t, 1, 4>& tet) {
  constexpr double round_off = 1e-13;  // of the product of the extents; the determinant's is below 1e-14
  const Vector3 o = x.row(tet[0]), a = x.row(tet[1]).transpose() - o, b = x.row(tet[2]).transpose() - o,
                c = x.row(tet[3]).transpose() - o;
  const double determinant = a.cross(b).dot(c);
  const Vector3 extent = a.cwiseAbs().cwiseMax(b.cwiseAbs()).cwiseMax(c.cwiseAbs());
  if (std::abs(determinant) > round_off * extent.prod()) return determinant < 0;
  using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
  std::array<Point, 4> p;
  for (int k = 0; k < 4; ++k) p[k] = Point(x(tet[k], 0), x(tet[k], 1), x(tet[k], 2));
  return CGAL::orientation(p[0], p[1], p[2], p[3]) == CGAL::NEGATIVE;
}

}  // namespace

std::vector<std::int32_t> surface_nodes(const Airway& airway) {
  std::vector<std::int32_t> nodes(airway.first.data(), airway.first.data() + airway.first.size());
  nodes.insert(nodes.end(), airway.second.data(), airway.second.data() + airway.second.size());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

Airway matched_airway(const Points& points, const Triangles& first, const Triangles& second,
                      const Vector3& direction) {
  if (first.rows() == 0 || second.rows() == 0)
    throw InvalidInput("matched_airway", first.rows() == 0 ? "triangles of first" : "triangles of second", 0, "",
                       "> 0");
  if (!(direction.norm() > 0) || !direction.allFinite())
    throw InvalidInput("matched_airway", "length of direction", direction.norm(), "", "> 0 and finite");
  require_indices("matched_airway", "node of first", first, points.rows());
  require_indices("matched_airway", "node of second", second, points.rows());
  const auto first_nodes = nodes_of(first), second_nodes = nodes_of(second);
  auto all = first_nodes;
  all.insert(all.end(), second_nodes.begin(), second_nodes.end());
  const double tolerance = 1e-6 * extent_of(points, all);
  if (!(tolerance > 0) || !std::isfinite(tolerance))
    throw InvalidInput("matched_airway", "extent of the surfaces", tolerance * 1e6, "m", "> 0 and finite");
  const Vector3 d = direction.normalized();
  const auto partner =
      partners(points, first_nodes, AcrossGrid(points, second_nodes, d, tolerance), "first", "second");
  partners(points, second_nodes, AcrossGrid(points, first_nodes, d, tolerance), "second", "first");

  std::vector<Triangle> offered;
  for (const auto& row : second.rowwise()) offered.push_back(from_smallest({row[0], row[1], row[2]}));
  std::sort(offered.begin(), offered.end());

  std::vector<std::int32_t> tets;
  for (std::ptrdiff_t f = 0; f < first.rows(); ++f) {
    const Triangle a{first(f, 0), first(f, 1), first(f, 2)};
    const Triangle b{partner.at(a[0]), partner.at(a[1]), partner.at(a[2])};
    const Vector3 p = points.row(a[0]).transpose(), q = points.row(a[1]).transpose(),
                  r = points.row(a[2]).transpose();
    if (!std::binary_search(offered.begin(), offered.end(), from_smallest({b[0], b[2], b[1]})))
      throw InvalidInput("matched_airway: triangle " + std::to_string(f) + " of first at " +
                         place_text((p + q + r) / 3) +
                         "; must have its mirrored partner, of opposite sense, in second. "
                         "Are both surfaces outward and cut by the same diagonals?");
    const auto begin = tets.size();
    cut_prism(a, b, tets);
    const double area = 0.5 * (q - p).cross(r - p).norm();
    for (auto t = begin; t < tets.size(); t += 4) {
      const Vector3 o = points.row(tets[t]).transpose(), s = points.row(tets[t + 1]).transpose(),
                    u = points.row(tets[t + 2]).transpose(), w = points.row(tets[t + 3]).transpose();
      const double volume = (s - o).cross(u - o).dot(w - o) / 6;
      if (volume < -tolerance * area / 3)  // touching bodies may overlap by the tolerance of the matching
        throw InvalidInput("matched_airway: air at triangle " + std::to_string(f) + " of first at " +
                           place_text((p + q + r) / 3) + ", volume = " + number_text(volume) +
                           " m^3; must be >= 0. Do the bodies overlap, or do the surfaces point into the tissue?");
    }
  }
  if (first.rows() != second.rows())
    throw InvalidInput("matched_airway", "triangles of second", static_cast<double>(second.rows()), "",
                       "as many as in first, " + std::to_string(first.rows()));
  return {first, second, Eigen::Map<const Tets>(tets.data(), static_cast<std::ptrdiff_t>(tets.size() / 4), 4),
          nullptr, direction.normalized()};
}

std::vector<std::int32_t> find_inverted(const Points& x, const Tets& tets) {
  std::vector<std::int32_t> all(static_cast<std::size_t>(tets.rows()));
  std::iota(all.begin(), all.end(), 0);
  return find_inverted(x, tets, all);
}

std::vector<std::int32_t> find_inverted(const Points& x, const Tets& tets,
                                        const std::vector<std::int32_t>& among) {
  require_indices("find_inverted", "tetrahedron",
                  Eigen::Map<const Indices>(among.data(), static_cast<std::ptrdiff_t>(among.size())), tets.rows());
  if (!x.allFinite()) throw InvalidInput("inverted: x is not finite; must be finite. Did the time step diverge?");
  std::vector<std::int32_t> found;
  for (const std::int32_t t : among) {
    require_indices("find_inverted", "node of a tetrahedron", tets.row(t), x.rows());
    if (is_inverted(x, tets.row(t))) found.push_back(t);
  }
  return found;
}

}  // namespace plica

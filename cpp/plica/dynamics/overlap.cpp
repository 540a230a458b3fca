#include "plica/dynamics/overlap.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>

#include "plica/mesh/edges.hpp"
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

namespace {

/// Nodes by their x.
std::vector<std::int32_t> along_x(std::vector<std::int32_t> nodes, const Points& x) {
  std::sort(nodes.begin(), nodes.end(), [&](std::int32_t a, std::int32_t b) { return x(a, 0) < x(b, 0); });
  return nodes;
}

/// Calls visit(cell, node, barycentric coordinates) for each of the nodes, sorted along x, in the box of a cell
/// that it is no node of; corners only. Until a visit is true, which it then is itself.
template <class Visit>
bool any_in_box_of_cell(const Points& x, const Cells& cells, const std::vector<std::int32_t>& nodes, Visit visit) {
  if (nodes.empty()) return false;
  Eigen::AlignedBox3d of_nodes;
  for (const std::int32_t node : nodes) of_nodes.extend(Vector3(x.row(node)));
  for (std::ptrdiff_t c = 0; c < cells.rows(); ++c) {
    Eigen::AlignedBox3d box;
    for (int k = 0; k < 4; ++k) box.extend(Vector3(x.row(cells(c, k))));
    if (!box.intersects(of_nodes)) continue;
    const Vector3 origin = x.row(cells(c, 0));
    Matrix3 edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = x.row(cells(c, k + 1)).transpose() - origin;
    const auto begin = std::lower_bound(nodes.begin(), nodes.end(), box.min()[0],
                                        [&](std::int32_t node, double value) { return x(node, 0) < value; });
    for (auto node = begin; node != nodes.end() && x(*node, 0) <= box.max()[0]; ++node) {
      const Vector3 p = x.row(*node);
      if (!box.contains(p) || (cells.row(c).array() == *node).any()) continue;
      const Vector3 w = edges.inverse() * (p - origin);
      if (visit(c, *node, Eigen::Vector4d(1 - w.sum(), w[0], w[1], w[2]))) return true;
    }
  }
  return false;
}

/// Four-node cells as they are; a ten-node cell as the four at its corners and four around the middle line from
/// the first to the last of its mid-side nodes.
Cells linear_cells(const Cells& cells) {
  if (cells.cols() == 4) return cells;
  constexpr std::array<std::array<int, 4>, 8> parts{{{0, 4, 6, 7},
                                                     {4, 1, 5, 8},
                                                     {6, 5, 2, 9},
                                                     {7, 8, 9, 3},
                                                     {4, 9, 5, 6},
                                                     {4, 9, 6, 7},
                                                     {4, 9, 7, 8},
                                                     {4, 9, 8, 5}}};
  Cells linear(8 * cells.rows(), 4);
  for (std::ptrdiff_t c = 0; c < cells.rows(); ++c)
    for (int part = 0; part < 8; ++part)
      for (int k = 0; k < 4; ++k) linear(8 * c + part, k) = cells(c, parts[part][k]);
  return linear;
}

}  // namespace

std::optional<std::int32_t> node_in_tissue(const Points& x, const Cells& cells, const Indices& nodes,
                                           double deep) {
  std::set<FaceKey> outer_faces;
  std::set<Edge> outer_edges;
  std::set<std::int32_t> outer_nodes;
  const Boundary hull = boundary_of(cells);
  for (const auto& f : hull.faces.rowwise()) {
    outer_faces.insert(face_key(f[0], f[1], f[2]));
    for (int k = 0; k < 3; ++k) {
      outer_edges.insert(edge(f[k], f[(k + 1) % 3]));
      outer_nodes.insert(f[k]);
    }
  }
  // Away from the tissue's boundary by `deep` of the cell: from each outer face, edge and corner that it has. A
  // point on a face between two cells is as much inside as one off it.
  const auto clear = [&](std::ptrdiff_t c, const Eigen::Vector4d& weights) {
    for (int k = 0; k < 4; ++k) {
      const std::int32_t node = cells(c, k);
      const FaceKey opposite = face_key(cells(c, (k + 1) % 4), cells(c, (k + 2) % 4), cells(c, (k + 3) % 4));
      if (!(weights[k] > (outer_faces.count(opposite) ? deep : -1e-9))) return false;
      if (outer_nodes.count(node) && !(1 - weights[k] > deep)) return false;
      for (int l = 0; l < k; ++l)
        if (outer_edges.count(edge(node, cells(c, l))) && !(1 - weights[k] - weights[l] > deep)) return false;
    }
    return true;
  };
  std::optional<std::int32_t> found;
  any_in_box_of_cell(x, cells, along_x({nodes.begin(), nodes.end()}, x),
                     [&](std::ptrdiff_t c, std::int32_t node, const Eigen::Vector4d& weights) {
                       if (clear(c, weights)) found = node;
                       return found.has_value();
                     });
  return found;
}

TissueOverlap::TissueOverlap(const Cells& cells, const Detector& detector, const Points& reference) {
  const Cells linear = linear_cells(cells);
  std::vector<std::vector<std::int32_t>> around(static_cast<std::size_t>(detector.node_count()));
  for (std::int32_t c = 0; c < linear.rows(); ++c)
    for (const std::int32_t node : linear.row(c)) around[static_cast<std::size_t>(node)].push_back(c);

  // From both surfaces, cell by cell, in turn.
  std::vector<int> side(static_cast<std::size_t>(linear.rows()), -1);
  std::array<std::vector<std::int32_t>, 2> front{detector.first().nodes(), detector.second().nodes()};
  std::array<std::vector<std::ptrdiff_t>, 2> rows;
  std::vector<char> seen(static_cast<std::size_t>(detector.node_count()), 0);
  for (const std::int32_t node : detector.nodes()) seen[static_cast<std::size_t>(node)] = 1;
  while (!front[0].empty() || !front[1].empty())
    for (int s = 0; s < 2; ++s) {
      std::vector<std::int32_t> next;
      for (const std::int32_t node : front[s])
        for (const std::int32_t c : around[static_cast<std::size_t>(node)]) {
          if (side[static_cast<std::size_t>(c)] >= 0) continue;
          side[static_cast<std::size_t>(c)] = s;
          rows[s].push_back(c);
          for (const std::int32_t of_cell : linear.row(c))
            if (char& known = seen[static_cast<std::size_t>(of_cell)]; !known) {
              known = 1;
              next.push_back(of_cell);
            }
        }
      front[s] = std::move(next);
    }
  const auto keep = [&](int s) {
    behind_[s] = linear(rows[s], Eigen::all);
    std::vector<std::int32_t>& nodes = nodes_behind_[s];
    nodes.assign(behind_[s].data(), behind_[s].data() + behind_[s].size());
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  };
  for (int s = 0; s < 2; ++s) keep(s);
  for (int s = 0; s < 2; ++s) {
    const Vector volumes = signed_volumes(reference, behind_[s]);
    std::set<std::ptrdiff_t> holding;
    each_inside(1 - s, reference, detector, 1e-6, [&](std::ptrdiff_t c, std::int32_t) { holding.insert(c); });
    std::vector<std::ptrdiff_t> telling;
    for (std::ptrdiff_t c = 0; c < volumes.size(); ++c)
      if (volumes[c] > 0 && !holding.count(c)) telling.push_back(rows[s][static_cast<std::size_t>(c)]);
    rows[s] = std::move(telling);
  }
  for (int s = 0; s < 2; ++s) keep(s);
}

template <class Visit>
void TissueOverlap::each_inside(int side, const Points& x, const Detector& detector, double least,
                                Visit visit) const {
  const ContactSurface &own = side == 0 ? detector.first() : detector.second(),
                       &other = side == 0 ? detector.second() : detector.first();
  Eigen::AlignedBox3d tissue;
  for (const std::int32_t node : nodes_behind_[1 - side]) tissue.extend(Vector3(x.row(node)));
  std::vector<std::int32_t> nodes;
  for (const std::int32_t node : own.nodes())
    if (!other.contains(node) && tissue.contains(Vector3(x.row(node)))) nodes.push_back(node);
  any_in_box_of_cell(x, behind_[1 - side], along_x(std::move(nodes), x),
                     [&](std::ptrdiff_t c, std::int32_t node, const Eigen::Vector4d& weights) {
                       if (weights.minCoeff() >= least) visit(c, node);
                       return false;
                     });
}

double TissueOverlap::depth(const Points& x, const Detector& detector) const {
  constexpr double on_a_face = -1e-9;  // a point between two cells lies in one of them
  double squared = 0;
  for (int s = 0; s < 2; ++s) {
    const ContactSurface& other = s == 0 ? detector.second() : detector.first();
    each_inside(s, x, detector, on_a_face, [&](std::ptrdiff_t, std::int32_t node) {
      squared = std::max(squared, other.closest(x, x.row(node)).squared_distance);
    });
  }
  return std::sqrt(squared);
}

}  // namespace plica

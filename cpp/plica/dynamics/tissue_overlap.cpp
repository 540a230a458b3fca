#include "plica/dynamics/tissue_overlap.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>

#include "plica/mesh/edges.hpp"
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

namespace {

Eigen::AlignedBox3d box_of(const Points& x, const std::vector<std::int32_t>& nodes) {
  Eigen::AlignedBox3d box;
  for (const std::int32_t node : nodes) box.extend(Vector3(x.row(node)));
  return box;
}

/// Points that are sought in boxes: sorted along the longest axis of their own.
class Sought {
 public:
  Sought(const Points& x, std::vector<std::int32_t> nodes)
      : x_(x), nodes_(std::move(nodes)), box_(box_of(x, nodes_)) {
    if (nodes_.empty()) return;
    box_.sizes().maxCoeff(&axis_);
    std::sort(nodes_.begin(), nodes_.end(),
              [&](std::int32_t a, std::int32_t b) { return x_(a, axis_) < x_(b, axis_); });
  }
  /// Calls visit(node) for each in the box, until it is true; whether it was.
  template <class Visit>
  bool any_in(const Eigen::AlignedBox3d& box, Visit visit) const {
    if (!box.intersects(box_)) return false;
    auto node = std::lower_bound(nodes_.begin(), nodes_.end(), box.min()[axis_],
                                 [&](std::int32_t at, double value) { return x_(at, axis_) < value; });
    for (; node != nodes_.end() && x_(*node, axis_) <= box.max()[axis_]; ++node)
      if (box.contains(Vector3(x_.row(*node))) && visit(*node)) return true;
    return false;
  }

 private:
  const Points& x_;
  std::vector<std::int32_t> nodes_;
  Eigen::AlignedBox3d box_;
  int axis_ = 0;
};

/// Calls visit(cell, node, barycentric coordinates) for each of the nodes in the box of one of the cells from
/// `first` to before `last` that it is no node of; corners only. Until a visit is true, which it then is itself.
template <class Visit>
bool any_in_box_of_cell(const Points& x, const Cells& cells, std::ptrdiff_t first, std::ptrdiff_t last,
                        const Sought& nodes, Visit visit) {
  for (std::ptrdiff_t c = first; c < last; ++c) {
    Eigen::AlignedBox3d box;
    for (int k = 0; k < 4; ++k) box.extend(Vector3(x.row(cells(c, k))));
    const bool found = nodes.any_in(box, [&](std::int32_t node) {
      if ((cells.row(c).array() == node).any()) return false;
      const Vector3 origin = x.row(cells(c, 0));
      Matrix3 edges;
      for (int k = 0; k < 3; ++k) edges.col(k) = x.row(cells(c, k + 1)).transpose() - origin;
      const Vector3 w = edges.inverse() * (Vector3(x.row(node)) - origin);
      return visit(c, node, Eigen::Vector4d(1 - w.sum(), w[0], w[1], w[2]));
    });
    if (found) return true;
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

Points centres_of(const Points& x, const Cells& cells) {
  Points centres(cells.rows(), 3);
  for (std::ptrdiff_t c = 0; c < cells.rows(); ++c) centres.row(c) = x(cells.row(c), Eigen::all).colwise().mean();
  return centres;
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
  any_in_box_of_cell(x, cells, 0, cells.rows(), Sought(x, {nodes.begin(), nodes.end()}),
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
  const Points centres = centres_of(reference, linear);
  const auto keep = [&](int s) {
    groups_[s].clear();
    gather(centres, rows[s], 0, static_cast<std::ptrdiff_t>(rows[s].size()), groups_[s]);
    behind_[s] = linear(rows[s], Eigen::all);
    for (Group& group : groups_[s]) {
      const auto own = behind_[s].middleRows(group.first, group.last - group.first);
      group.nodes.assign(own.data(), own.data() + own.size());
      std::sort(group.nodes.begin(), group.nodes.end());
      group.nodes.erase(std::unique(group.nodes.begin(), group.nodes.end()), group.nodes.end());
    }
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

void TissueOverlap::gather(const Points& centres, std::vector<std::ptrdiff_t>& cells, std::ptrdiff_t first,
                           std::ptrdiff_t last, std::vector<Group>& groups) {
  constexpr std::ptrdiff_t most = 32;
  if (first == last) return;
  if (last - first <= most) {
    groups.push_back({first, last, {}});
    return;
  }
  Eigen::AlignedBox3d box;
  for (std::ptrdiff_t i = first; i < last; ++i)
    box.extend(Vector3(centres.row(cells[static_cast<std::size_t>(i)])));
  int axis = 0;
  box.sizes().maxCoeff(&axis);
  const std::ptrdiff_t middle = (first + last) / 2;
  std::nth_element(cells.begin() + first, cells.begin() + middle, cells.begin() + last,
                   [&](std::ptrdiff_t a, std::ptrdiff_t b) { return centres(a, axis) < centres(b, axis); });
  gather(centres, cells, first, middle, groups);
  gather(centres, cells, middle, last, groups);
}

template <class Visit>
void TissueOverlap::each_inside(int side, const Points& x, const Detector& detector, double least,
                                Visit visit) const {
  const ContactSurface &own = side == 0 ? detector.first() : detector.second(),
                       &other = side == 0 ? detector.second() : detector.first();
  const std::vector<Group>& groups = groups_[1 - side];
  std::vector<Eigen::AlignedBox3d> boxes;
  Eigen::AlignedBox3d tissue;
  for (const Group& group : groups) tissue.extend(boxes.emplace_back(box_of(x, group.nodes)));
  std::vector<std::int32_t> nodes;
  for (const std::int32_t node : own.nodes())
    if (!other.contains(node) && tissue.contains(Vector3(x.row(node)))) nodes.push_back(node);
  if (nodes.empty()) return;
  const Sought sought(x, std::move(nodes));
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (!sought.any_in(boxes[g], [](std::int32_t) { return true; })) continue;
    any_in_box_of_cell(x, behind_[1 - side], groups[g].first, groups[g].last, sought,
                       [&](std::ptrdiff_t c, std::int32_t node, const Eigen::Vector4d& weights) {
                         if (weights.minCoeff() >= least) visit(c, node);
                         return false;
                       });
  }
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

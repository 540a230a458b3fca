#include "plica/mesh/mirror.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/mesh/edges.hpp"

namespace plica {

namespace {

constexpr double symmetric = 1e-6;  // of a field's largest entry

std::string plane_name(std::size_t plane) { return std::string("the plane ") + "xy"[plane] + " = 0"; }

double mean_edge(const TetMesh& mesh) {
  double sum = 0;
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c)
    for (const auto& [a, b] : tet_edges)
      sum += (mesh.points.row(mesh.cells(c, a)) - mesh.points.row(mesh.cells(c, b))).norm();
  return sum / static_cast<double>(6 * mesh.cell_count());
}

/// Nodes in the order of their position along a direction that no plane of a mesh lies across.
class ByPosition {
 public:
  explicit ByPosition(const Points& x)
      : x_(x), along_(x * direction()), order_(static_cast<std::size_t>(x.rows())) {
    std::iota(order_.begin(), order_.end(), 0);
    std::sort(order_.begin(), order_.end(), [&](auto a, auto b) { return along_[a] < along_[b]; });
  }
  /// Those within `reach` of a place.
  std::vector<std::int32_t> near(const Vector3& place, double reach) const {
    const double at = direction().dot(place);
    auto i = std::lower_bound(order_.begin(), order_.end(), at - reach,
                              [&](std::int32_t node, double value) { return along_[node] < value; });
    std::vector<std::int32_t> found;
    for (; i != order_.end() && along_[*i] <= at + reach; ++i)
      if ((x_.row(*i).transpose() - place).norm() <= reach) found.push_back(*i);
    return found;
  }

 private:
  static Vector3 direction() { return {0.5423, 0.2917, 0.7879}; }  // of length 1, nearly

  const Points& x_;
  Vector along_;
  std::vector<std::int32_t> order_;
};

template <typename Row>
std::vector<std::int32_t> sorted(const Row& row) {
  std::vector<std::int32_t> nodes(row.begin(), row.end());
  std::sort(nodes.begin(), nodes.end());
  return nodes;
}

}  // namespace

MirrorImages::MirrorImages(const TetMesh& mesh, Symmetry symmetry)
    : partner_(symmetry == Symmetry::quarter ? 2 : 1, Indices(mesh.node_count())) {
  require_size("MirrorImages", "a row of cells", mesh.cells.cols(), 4, 10);
  require_at_least("MirrorImages", "cells", mesh.cell_count(), 1);
  require_indices("MirrorImages", "node of a cell", mesh.cells, mesh.node_count());
  pair_nodes(mesh, tolerance * mean_edge(mesh));
  pair_cells(mesh);
}

void MirrorImages::pair_nodes(const TetMesh& mesh, double reach) {
  const Points& x = mesh.points;
  const auto count = static_cast<std::int32_t>(x.rows());
  const ByPosition by_position(x);
  for (std::size_t plane = 0; plane < planes(); ++plane)
    for (std::int32_t i = 0; i < count; ++i) {
      Vector3 image = x.row(i);
      image[static_cast<int>(plane)] *= -1;
      const std::vector<std::int32_t> found = by_position.near(image, reach);
      if (found.size() != 1)
        throw InvalidInput("Scene: symmetry: node " + std::to_string(i) + " at " + place_text(x.row(i)) + " has " +
                           (found.empty() ? "no node" : "several nodes") + " at its mirror image in " +
                           plane_name(plane) + " within " + number_text(reach) +
                           " m; must have one. Leave symmetry out, or mirror the mesh.");
      partner_[plane][i] = found.front();
    }
  node_of_.resize(count);
  turned_.assign(static_cast<std::size_t>(count), 0);
  std::vector<std::int32_t> own, local(static_cast<std::size_t>(count), -1);
  for (std::int32_t i = 0; i < count; ++i) {
    std::int32_t from = i;
    for (std::size_t plane = 0; plane < planes(); ++plane)
      if (partner_[plane][i] != i && x(i, static_cast<int>(plane)) < 0) {
        from = partner_[plane][from];
        turned_[static_cast<std::size_t>(i)] |= static_cast<std::uint8_t>(1 << plane);
      }
    node_of_[i] = from;
    if (from != i) continue;
    local[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(own.size());
    own.push_back(i);
  }
  nodes_ = Eigen::Map<Indices>(own.data(), static_cast<std::ptrdiff_t>(own.size()));
  images_ = Vector::Zero(nodes_.size());
  for (std::int32_t i = 0; i < count; ++i) {
    node_of_[i] = local[static_cast<std::size_t>(node_of_[i])];
    images_[node_of_[i]] += 1;
  }
}

void MirrorImages::pair_cells(const TetMesh& mesh) {
  const auto centre = [&](std::ptrdiff_t c) {
    return Vector3(mesh.points(mesh.cells.row(c), Eigen::all).colwise().mean());
  };
  const auto own = [&](std::ptrdiff_t c) {
    Indices nodes(mesh.cells.cols());
    for (std::ptrdiff_t k = 0; k < nodes.size(); ++k) nodes[k] = node_of_[mesh.cells(c, k)];
    return sorted(nodes);
  };
  std::map<std::vector<std::int32_t>, std::int32_t> part;  // its cells, by their nodes
  std::vector<std::int32_t> cells;
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c) {
    bool inside = true;
    for (std::size_t plane = 0; plane < planes(); ++plane) {
      bool here = false, there = false;
      for (const std::int32_t node : mesh.cells.row(c))
        if (partner_[plane][node] != node) (mirrored(plane, node) ? there : here) = true;
      if (here && there)
        throw InvalidInput("Scene: symmetry: the cell " + std::to_string(c) + " at " + place_text(centre(c)) +
                           " lies on both sides of " + plane_name(plane) +
                           "; must lie on one. Leave symmetry out, or mesh it with faces in that plane.");
      inside = inside && !there;
    }
    if (!inside) continue;
    part.emplace(own(c), static_cast<std::int32_t>(cells.size()));
    cells.push_back(static_cast<std::int32_t>(c));
  }
  cells_ = Eigen::Map<Indices>(cells.data(), static_cast<std::ptrdiff_t>(cells.size()));
  cell_of_.resize(mesh.cell_count());
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c) {
    const auto found = part.find(own(c));
    if (found == part.end())
      throw InvalidInput(
          "Scene: symmetry: the cell " + std::to_string(c) + " at " + place_text(centre(c)) +
          " has no cell at its mirror image; must have one. Leave symmetry out, or mirror the mesh.");
    cell_of_[c] = found->second;
  }
  if (mesh.cell_count() != copies() * cells_.size())
    throw InvalidInput("Scene: symmetry", "cells", static_cast<double>(mesh.cell_count()), "",
                       std::to_string(copies()) + " times the " + std::to_string(cells_.size()) +
                           " of the part that is solved for");
}

Indices MirrorImages::nodes_of(const Indices& nodes) const {
  require_indices("MirrorImages", "node", nodes, node_of_.size());
  std::vector<std::int32_t> own;
  for (const std::int32_t node : nodes) own.push_back(node_of_[node]);
  std::sort(own.begin(), own.end());
  own.erase(std::unique(own.begin(), own.end()), own.end());
  return Eigen::Map<Indices>(own.data(), static_cast<std::ptrdiff_t>(own.size()));
}

std::int32_t MirrorImages::image(int copy, std::int32_t part_node) const {
  require_index("MirrorImages", "copy", copy, copies());
  require_index("MirrorImages", "part_node", part_node, nodes_.size());
  std::int32_t node = nodes_[part_node];
  for (std::size_t plane = 0; plane < planes(); ++plane)
    if ((copy >> plane & 1) != 0) node = partner_[plane][node];
  return node;
}

SparseMatrix MirrorImages::unfolded(const SparseMatrix& folded) const {
  require_size("MirrorImages", "rows of the matrix", folded.rows(), 3 * nodes_.size());
  require_size("MirrorImages", "columns of the matrix", folded.cols(), 3 * nodes_.size());
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(folded.nonZeros() * copies()));
  for (int copy = 0; copy < copies(); ++copy) {
    const auto row = [&](Eigen::Index own) {
      return 3 * image(copy, static_cast<std::int32_t>(own / 3)) + static_cast<std::int32_t>(own % 3);
    };
    const auto turned = [&](Eigen::Index own) { return (copy >> own % 3 & 1) != 0; };
    for (Eigen::Index outer = 0; outer < folded.outerSize(); ++outer)
      for (SparseMatrix::InnerIterator entry(folded, outer); entry; ++entry) {
        const double share = entry.value() / copies();
        entries.emplace_back(row(entry.row()), row(entry.col()),
                             turned(entry.row()) == turned(entry.col()) ? share : -share);
      }
  }
  SparseMatrix whole(3 * node_of_.size(), 3 * node_of_.size());
  whole.setFromTriplets(entries.begin(), entries.end());
  return whole;
}

Vector MirrorImages::spread(const Vector& q) const {
  require_size("MirrorImages", "q", q.size(), 3 * nodes_.size());
  Vector u(3 * node_of_.size());
  for (std::int32_t i = 0; i < node_of_.size(); ++i)
    u.segment<3>(3 * static_cast<std::ptrdiff_t>(i)) = row_of(i, q);
  return u;
}

Vector MirrorImages::folded(const Vector& f) const {
  require_size("MirrorImages", "f", f.size(), 3 * node_of_.size());
  Vector sum = Vector::Zero(3 * nodes_.size());
  add_folded(f, Indices::LinSpaced(node_of_.size(), 0, static_cast<std::int32_t>(node_of_.size()) - 1), sum);
  return sum;
}

void MirrorImages::add_folded(const Vector& f, const Indices& nodes, Vector& sum) const {
  require_size("MirrorImages", "f", f.size(), 3 * node_of_.size());
  require_size("MirrorImages", "sum", sum.size(), 3 * nodes_.size());
  require_indices("MirrorImages", "node", nodes, node_of_.size());
  for (const std::int32_t node : nodes)
    sum.segment<3>(3 * static_cast<std::ptrdiff_t>(node_of_[node])) +=
        sign_of(node).cwiseProduct(f.segment<3>(3 * static_cast<std::ptrdiff_t>(node)));
}

Vector MirrorImages::shared(const Vector& f) const {
  require_size("MirrorImages", "f", f.size(), 3 * nodes_.size());
  Vector share = f;
  for (std::ptrdiff_t i = 0; i < nodes_.size(); ++i) share.segment<3>(3 * i) /= images_[i];
  return spread(share);
}

void MirrorImages::require_symmetric_field(const Vector& field, const std::string& name,
                                           const Points& places) const {
  require_size("MirrorImages", "the field", field.size(), 3 * node_of_.size());
  require_size("MirrorImages", "places", places.rows(), node_of_.size());
  const double least = symmetric * field.cwiseAbs().maxCoeff();
  for (std::size_t plane = 0; plane < planes(); ++plane) {
    const auto across = static_cast<std::ptrdiff_t>(plane);
    for (std::int32_t i = 0; i < node_of_.size(); ++i) {
      const std::int32_t partner = partner_[plane][i];
      if (partner < i) continue;  // the pair has been looked at
      const double *here = field.data() + 3 * static_cast<std::ptrdiff_t>(i),
                   *there = field.data() + 3 * static_cast<std::ptrdiff_t>(partner);
      bool same = true;
      for (std::ptrdiff_t k = 0; k < 3; ++k)
        same &= std::abs(k == across ? there[k] + here[k] : there[k] - here[k]) <= least;
      if (same) continue;
      Vector3 image(there[0], there[1], there[2]);
      image[across] *= -1;
      throw InvalidInput("Scene: symmetry: " + name + " at node " + std::to_string(i) + ", " +
                         place_text(places.row(i)) + ", is (" + number_text(here[0]) + ", " +
                         number_text(here[1]) + ", " + number_text(here[2]) + "), mirrored in " +
                         plane_name(plane) + " (" + number_text(image[0]) + ", " + number_text(image[1]) + ", " +
                         number_text(image[2]) + "); must be the same. Leave symmetry out, or make it symmetric.");
    }
  }
}

Vector MirrorImages::folded_symmetric(const Vector& force, const std::string& name, const Points& places) const {
  require_symmetric_field(force, name, places);
  return folded(force);
}

Vector MirrorImages::part_of(const Vector& field, const std::string& name, const Points& places) const {
  require_symmetric_field(field, name, places);
  Vector part(3 * nodes_.size());
  for (std::ptrdiff_t i = 0; i < nodes_.size(); ++i) {
    part.segment<3>(3 * i) = field.segment<3>(3 * static_cast<std::ptrdiff_t>(nodes_[i]));
    for (std::size_t plane = 0; plane < planes(); ++plane)
      if (partner_[plane][nodes_[i]] == nodes_[i]) part[3 * i + static_cast<std::ptrdiff_t>(plane)] = 0;
  }
  return part;
}

void MirrorImages::require_symmetric(const std::vector<Triangles>& sides, const std::string& name,
                                     const Points& places) const {
  require_size("MirrorImages", "places", places.rows(), node_of_.size());
  for (const Triangles& side : sides) require_indices("MirrorImages", "node of a side", side, node_of_.size());
  std::map<std::vector<std::int32_t>, std::size_t> side_of;
  for (std::size_t side = 0; side < sides.size(); ++side)
    for (const auto& face : sides[side].rowwise()) side_of.emplace(sorted(face), side);
  for (std::size_t plane = 0; plane < planes(); ++plane)
    for (std::size_t side = 0; side < sides.size(); ++side) {
      std::size_t of_first = sides.size();
      for (const auto& face : sides[side].rowwise()) {
        Indices image(face.size());
        for (std::ptrdiff_t k = 0; k < image.size(); ++k) image[k] = partner_[plane][face[k]];
        const auto found = side_of.find(sorted(image));
        if (found != side_of.end() && of_first == sides.size()) of_first = found->second;
        if (found == side_of.end() || found->second != of_first)
          throw InvalidInput("Scene: symmetry: the mirror image in " + plane_name(plane) + " of the face of " +
                             name + " at " + place_text(places(face, Eigen::all).colwise().mean()) +
                             " is not one of its faces; must be. Leave symmetry out, or mirror the surface.");
      }
    }
}

TetMesh MirrorImages::part(const TetMesh& mesh) const {
  require_size("MirrorImages", "points of the mesh", mesh.node_count(), node_of_.size());
  require_size("MirrorImages", "cells of the mesh", mesh.cell_count(), cell_of_.size());
  TetMesh part;
  part.points = mesh.points(nodes_, Eigen::all);
  if (mesh.stretched()) part.rest = mesh.rest(nodes_, Eigen::all);
  part.cells = mesh.cells(cells_, Eigen::all);
  for (std::int32_t& node : part.cells.reshaped()) node = node_of_[node];
  if (mesh.cell_layer.size() > 0) part.cell_layer = mesh.cell_layer(cells_);
  if (mesh.cell_side.size() > 0) part.cell_side = mesh.cell_side(cells_);
  part.layer_names = mesh.layer_names;
  return part;
}

}  // namespace plica

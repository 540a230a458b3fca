#pragma once
#include <array>

#include "plica/core/block_matrix.hpp"
#include "plica/core/require.hpp"
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

/// Planes in which a body is its own mirror image: half, x = 0 (left and right); quarter, x = 0 and y = 0 (front
/// and back).
enum class Symmetry { half, quarter };

/// Every node of a symmetric mesh as the image of one in its part x >= 0, for a quarter y >= 0, too. A
/// displacement q of the part's nodes moves all of them by S q, whose rows are those of q, some components with
/// their sign turned; S^T adds up the forces on a node's images. Nodal vectors of all nodes are (3 n), of the part
/// (3 p).
class MirrorImages {
 public:
  static constexpr double tolerance = 1e-9;  // mean edges, by which an image may lie beside its node

  /// Throws InvalidInput naming a node without image, or a cell that a plane cuts.
  MirrorImages(const TetMesh& mesh, Symmetry symmetry);

  std::size_t planes() const { return partner_.size(); }  // the first is x = 0
  int copies() const { return 1 << planes(); }            // of the part that make the whole
  const Indices& nodes() const { return nodes_; }         // (p) of the part, in the whole; ascending
  const Indices& cells() const { return cells_; }         // (c) likewise
  /// (m) Of the part, by its number there, that each cell of the whole is an image of.
  const Indices& cell_of() const { return cell_of_; }
  /// Number in the part of the node that this one is an image of, and the signs of its components.
  std::int32_t node_of(std::int32_t node) const {
    require_node(node);
    return node_of_[node];
  }
  Vector3 sign(std::int32_t node) const {
    require_node(node);
    return sign_of(node);
  }
  /// How many nodes of the whole a node of the part stands for, itself included.
  double count(std::int32_t part_node) const {
    require_index("MirrorImages", "node of the part", part_node, images_.size());
    return images_[part_node];
  }
  Indices nodes_of(const Indices& nodes) const;  // ascending, each once
  /// Node that this one is mirrored to, itself where it lies in the plane.
  std::int32_t partner(std::size_t plane, std::int32_t node) const {
    require_plane(plane);
    require_node(node);
    return partner_[plane][node];
  }
  /// Node that one of the part (by its number there) is mirrored to in copy 0 ... copies() - 1 of the part: bit k
  /// of the copy stands for plane k, which turns the sign of component k. Copy 0 is the part itself.
  std::int32_t image(int copy, std::int32_t part_node) const;
  /// Whether it was mirrored in a plane to come from the part.
  bool mirrored(std::size_t plane, std::int32_t node) const {
    require_plane(plane);
    require_node(node);
    return (turned_[static_cast<std::size_t>(node)] >> plane & 1) != 0;
  }

  /// Row of S q.
  Vector3 at(std::int32_t node, const Vector& q) const {
    require_node(node);
    require_size("MirrorImages", "q", q.size(), 3 * nodes_.size());
    return row_of(node, q);
  }
  Vector spread(const Vector& q) const;  // S q
  Vector folded(const Vector& f) const;  // S^T f
  /// Adds S^T f of forces on these nodes alone to `sum` (3 p).
  void add_folded(const Vector& f, const Indices& nodes, Vector& sum) const;
  /// The symmetric forces on all nodes whose sum over images is f: S (S^T S)^-1 f.
  Vector shared(const Vector& f) const;
  /// The matrix (3 n, 3 n) of the whole that one of the part is the S^T A S of, if cells alone make it up, as
  /// mass, viscosity and stiffness: each copy of the part adds its share. O(entries).
  SparseMatrix unfolded(const SparseMatrix& folded) const;
  /// The part's rows of a symmetric field (3 n), its components across the planes zero there. Throws InvalidInput
  /// naming the node where it differs from its mirror image by more than 1e-6 of the field's largest entry.
  Vector part_of(const Vector& field, const std::string& name, const Points& places) const;
  /// S^T of forces (3 n) that are symmetric; throws as part_of.
  Vector folded_symmetric(const Vector& force, const std::string& name, const Points& places) const;
  /// Throws InvalidInput where the mirror image of one of these faces is none of them; with several sides, where
  /// the image of a side is not one.
  void require_symmetric(const std::vector<Triangles>& sides, const std::string& name, const Points& places) const;

  /// The part of the mesh, without surfaces and node sets.
  TetMesh part(const TetMesh& mesh) const;

  /// Throws InvalidInput naming the first node of a field (3 n) that is not its image's, and its place (m).
  void require_symmetric_field(const Vector& field, const std::string& name, const Points& places) const;

 private:
  void require_node(std::int32_t node) const { require_index("MirrorImages", "node", node, node_of_.size()); }
  void require_plane(std::size_t plane) const {
    require_index("MirrorImages", "plane", static_cast<std::ptrdiff_t>(plane),
                  static_cast<std::ptrdiff_t>(planes()));
  }
  Vector3 sign_of(std::int32_t node) const {
    const std::uint8_t turned = turned_[static_cast<std::size_t>(node)];
    return {turned & 1 ? -1.0 : 1.0, turned & 2 ? -1.0 : 1.0, 1.0};
  }
  Vector3 row_of(std::int32_t node, const Vector& q) const {
    return sign_of(node).cwiseProduct(q.segment<3>(3 * static_cast<std::ptrdiff_t>(node_of_[node])));
  }
  void pair_nodes(const TetMesh& mesh, double reach);
  void pair_cells(const TetMesh& mesh);

  std::vector<Indices> partner_;  // (n) a plane
  Indices node_of_, nodes_, cell_of_, cells_;
  std::vector<std::uint8_t> turned_;  // (n) bit k: mirrored in plane k
  Vector images_;                     // (p) of each node
};

}  // namespace plica

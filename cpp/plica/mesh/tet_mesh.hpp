#pragma once
#include <map>
#include <optional>
#include <string>

#include "plica/core/types.hpp"

namespace plica {

/// Side of the patient: of a larynx about the origin left is x < 0, right is x > 0 (Paper A, Sec. 3); y is
/// anteroposterior, z points up.
enum class Side : std::int8_t { none = 0, left = 1, right = 2 };

/// Linear (4 nodes) or quadratic (10 nodes, VTK order) tetrahedra with their labels.
/// Mid-side nodes of order 2: edges (0,1) (1,2) (2,0) (0,3) (1,3) (2,3); faces: (0,1) (1,2) (2,0).
/// Labels may be left empty: a mesh without layers has one, without sides none; labelled() writes that out.
struct TetMesh {
  Points points;                             // (n, 3) m
  Cells cells;                               // (m, 4) or (m, 10)
  Indices cell_layer;                        // (m) position in layer_names, or empty
  Indices cell_side;                         // (m) a Side, or empty
  std::vector<std::string> layer_names;      // e.g. body, ligament, cover
  std::map<std::string, Faces> surfaces;     // named boundary faces, outward, e.g. airway_left, airway_right
  std::map<std::string, Indices> node_sets;  // named nodes, e.g. wall
  /// (n, 3) m, where the tissue was before it was stretched to `points` (docs/theory/posture.md); empty: there.
  Points rest{};

  int order() const { return cells.cols() == 10 ? 2 : 1; }
  std::ptrdiff_t node_count() const { return points.rows(); }
  std::ptrdiff_t cell_count() const { return cells.rows(); }
  bool stretched() const { return rest.rows() > 0; }
  /// The surface of that name; throws InvalidInput that lists the names there are.
  const Faces& surface(const std::string& name) const;
  const Indices& node_set(const std::string& name) const;
};

/// The same mesh with a label at every cell: left empty, of the layer "body", or the only one named, and no side.
TetMesh labelled(TetMesh mesh);

/// Signed volume of each tetrahedron, V = det[x1-x0, x2-x0, x3-x0] / 6 (m^3), negative where inverted.
/// Corners only. O(m).
Vector signed_volumes(const Points& x, const Cells& cells);

/// det dx/dxi of cell e at one of its nodes k, m^3: 6 V everywhere in a cell with straight sides.
double jacobian_at_node(const Points& x, const Cells& cells, Eigen::Index e, int k);
/// Cells whose det dx/dxi is not positive at one of their nodes: inside out, or folded over there. O(m).
std::ptrdiff_t folded_cells(const Points& x, const Cells& cells);
/// The same where only these cells may be.
std::ptrdiff_t folded_cells(const Points& x, const Cells& cells, const std::vector<std::int32_t>& suspects);
/// The lowest of them.
std::optional<std::ptrdiff_t> first_folded_cell(const Points& x, const Cells& cells);

/// Faces (f, 3 or 6) that belong to one cell only, outward; the cell of each in `cell_of_face`. O(m log m).
struct Boundary {
  Faces faces;
  Indices cell_of_face;
};
Boundary boundary_of(const Cells& cells);

/// From where coordinates are counted so that sums with displacements round as those of a mesh at the origin:
/// along each axis the middle of the points where it is further away than their box is wide, else 0.
Vector3 origin_near(const Points& x);

/// For each node the lowest node of its body: cells that share nodes are one. O(m).
Indices body_of_nodes(const TetMesh& mesh);

/// Each six-node face as four flat triangles, three-node faces as they are: (4 f, 3) or (f, 3).
/// Order within a face: corner 0, corner 1, corner 2, middle.
Triangles flat_triangles(const Faces& faces);

/// The same mesh with a node in the middle of every edge (straight sides); labels, surfaces and node
/// sets follow (a mid-side node is in a set if both its ends are). Throws if already quadratic.
TetMesh to_quadratic(const TetMesh& linear);

/// Throws InvalidInput naming the first offender, its place, and what to do: wrong shapes, a coordinate that
/// is not finite, an index out of range (node, layer, side), node without cell, inverted or flat cell (also
/// one with curved sides that folds over at a node), duplicate or overlapping cell, an edge with two mid-side
/// nodes, an empty surface or node set, a surface face that is not a boundary face of a cell or points
/// inward, non-manifold surface (an edge of it with more than two faces). Coincident nodes are allowed: bodies
/// may touch.
/// Also a mesh so far away that double precision spaces its coordinates by more than 1e-6 of its shortest edge, a
/// tenth of contact's tolerance: what a gap is, is lost in them. O(m log m).
void check_mesh(const TetMesh& mesh);

}  // namespace plica

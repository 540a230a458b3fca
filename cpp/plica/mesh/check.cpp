#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/mesh/edges.hpp"
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

namespace {

[[noreturn]] void refuse(const std::string& what, const std::string& hint) {
  throw InvalidInput("TetMesh: " + what + ". " + hint);
}

std::string at(const Eigen::RowVector3d& x) {
  return "(" + number_text(x[0]) + ", " + number_text(x[1]) + ", " + number_text(x[2]) + ") m";
}

std::string node_name(const TetMesh& mesh, std::int32_t node) {
  return "node " + std::to_string(node) + " at " + at(mesh.points.row(node));
}

std::string cell_name(const TetMesh& mesh, Eigen::Index e) {
  Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
  for (int k = 0; k < 4; ++k) centre += mesh.points.row(mesh.cells(e, k)) / 4;
  return "cell " + std::to_string(e) + " at " + at(centre);
}

void check_shapes(const TetMesh& mesh) {
  const auto sized = [](const std::string& name, Eigen::Index size, Eigen::Index cells) {
    if (size != cells)
      throw InvalidInput("TetMesh", "size of " + name, static_cast<double>(size), "",
                         std::to_string(cells) + ", the number of cells", "It has one entry per cell.");
  };
  if (mesh.cell_count() == 0) refuse("there is no cell", "Give at least one tetrahedron.");
  if (mesh.cells.cols() != 4 && mesh.cells.cols() != 10)
    throw InvalidInput("TetMesh", "nodes per cell", static_cast<double>(mesh.cells.cols()), "", "4 or 10",
                       "Only tetrahedra, linear or quadratic, are known.");
  if (mesh.cell_layer.size() > 0 || mesh.layer_names.size() > 1)
    sized("cell_layer", mesh.cell_layer.size(), mesh.cell_count());
  if (mesh.cell_side.size() > 0) sized("cell_side", mesh.cell_side.size(), mesh.cell_count());
  for (Eigen::Index n = 0; n < mesh.node_count(); ++n)
    if (!mesh.points.row(n).allFinite())
      refuse("node " + std::to_string(n) + " is at " + at(mesh.points.row(n)) + "; its coordinates must be finite",
             "Look for missing values where the points were read.");
}

void check_rest(const TetMesh& mesh) {
  if (!mesh.stretched()) return;
  require_size("Mesh", "rest", mesh.rest.rows(), mesh.node_count());
  if (!mesh.rest.allFinite()) refuse("a place at rest is not finite", "Stretch the mesh again.");
}

void check_indices(const TetMesh& mesh) {
  const auto nodes = static_cast<std::int32_t>(mesh.node_count());
  const std::string range = "; must be in [0, " + std::to_string(nodes) + ")";
  std::vector<char> used(nodes, 0);
  for (Eigen::Index e = 0; e < mesh.cell_count(); ++e)
    for (const std::int32_t node : mesh.cells.row(e)) {
      if (node < 0 || node >= nodes)
        refuse("cell " + std::to_string(e) + " names node " + std::to_string(node) + range,
               "Count nodes from 0, and give all points.");
      used[node] = 1;
    }
  for (std::int32_t n = 0; n < nodes; ++n)
    if (!used[n]) refuse(node_name(mesh, n) + " belongs to no cell", "Remove it and renumber the nodes.");
  const auto layers = static_cast<std::int32_t>(mesh.layer_names.size());
  for (Eigen::Index e = 0; e < mesh.cell_layer.size(); ++e)
    if (mesh.cell_layer[e] < 0 || mesh.cell_layer[e] >= layers)
      refuse(cell_name(mesh, e) + " has layer " + std::to_string(mesh.cell_layer[e]) + "; must be in [0, " +
                 std::to_string(layers) + ")",
             "Give layer_names an entry for every layer.");
  for (Eigen::Index e = 0; e < mesh.cell_side.size(); ++e)
    if (mesh.cell_side[e] < 0 || mesh.cell_side[e] > 2)
      refuse(cell_name(mesh, e) + " has side " + std::to_string(mesh.cell_side[e]) + "; must be 0, 1 or 2",
             "0 is none, 1 left (x < 0), 2 right.");
}

void check_volumes(const TetMesh& mesh) {
  const Vector volumes = signed_volumes(mesh.points, mesh.cells);
  for (Eigen::Index e = 0; e < mesh.cell_count(); ++e) {
    double longest = 0;
    for (const auto& [a, b] : tet_edges)
      longest = std::max(longest, (mesh.points.row(mesh.cells(e, a)) - mesh.points.row(mesh.cells(e, b))).norm());
    const double flat = 1e-12 * longest * longest * longest;  // a volume below it is roundoff
    const std::string value = " has volume " + number_text(volumes[e]) + " m^3; must be > 0";
    if (volumes[e] < -flat)
      refuse(cell_name(mesh, e) + value, "It is inverted: exchange two of its corners, or undo a mirroring.");
    if (volumes[e] <= flat) refuse(cell_name(mesh, e) + value, "It is flat: remove it or move a node.");
    if (mesh.order() == 1) continue;
    for (int k = 0; k < 10; ++k) {
      const double local = jacobian_at_node(mesh.points, mesh.cells, e, k);
      if (!(local > flat))
        refuse(cell_name(mesh, e) + " folds over at its " + node_name(mesh, mesh.cells(e, k)) +
                   ": det dx/dxi = " + number_text(local) + " m^3; must be > 0",
               "Are its mid-side nodes in VTK order (Gmsh exchanges the last two)? If so, curve its sides less.");
    }
  }
}

void check_duplicates(const TetMesh& mesh) {
  std::map<std::array<std::int32_t, 4>, Eigen::Index> seen;
  std::map<FaceKey, int> uses;
  for (Eigen::Index e = 0; e < mesh.cell_count(); ++e) {
    std::array<std::int32_t, 4> corners{};
    for (int k = 0; k < 4; ++k) corners[k] = mesh.cells(e, k);
    std::sort(corners.begin(), corners.end());
    const auto [first, fresh] = seen.emplace(corners, e);
    if (!fresh)
      refuse(cell_name(mesh, e) + " has the corners of cell " + std::to_string(first->second),
             "Remove one of them.");
    for (const auto& f : tet_faces)
      if (++uses[face_key(mesh.cells(e, f[0]), mesh.cells(e, f[1]), mesh.cells(e, f[2]))] > 2)
        refuse(cell_name(mesh, e) + " shares a face with two other cells", "Cells must not overlap: remove one.");
  }
}

void check_middles(const TetMesh& mesh) {
  if (mesh.order() == 1) return;
  std::map<Edge, std::int32_t> middle;
  std::map<std::int32_t, Edge> owner;
  std::vector<char> corner(mesh.node_count(), 0);
  for (const std::int32_t node : mesh.cells.leftCols(4).reshaped()) corner[node] = 1;
  for (Eigen::Index e = 0; e < mesh.cell_count(); ++e)
    for (int k = 0; k < 6; ++k) {
      const Edge ends = edge(mesh.cells(e, tet_edges[k][0]), mesh.cells(e, tet_edges[k][1]));
      const std::int32_t node = mesh.cells(e, 4 + k);
      const bool known = middle.emplace(ends, node).first->second == node;
      if (!known || owner.emplace(node, ends).first->second != ends || corner[node])
        refuse(cell_name(mesh, e) + " has " + node_name(mesh, node) + " between nodes " + std::to_string(ends[0]) +
                   " and " + std::to_string(ends[1]) + ", where another cell has another one",
               "Every edge has one mid-side node of its own: join coincident ones, and mind the VTK order.");
    }
}

std::string face_name(const TetMesh& mesh, const std::string& name, Eigen::Index f) {
  const std::int32_t node = mesh.surfaces.at(name)(f, 0);
  return "surface \"" + name + "\": face " + std::to_string(f) + " with " + node_name(mesh, node);
}

void check_surfaces(const TetMesh& mesh) {
  const Boundary hull = boundary_of(mesh.cells);
  std::map<FaceKey, Eigen::Index> outside;
  for (Eigen::Index f = 0; f < hull.faces.rows(); ++f)
    outside[face_key(hull.faces(f, 0), hull.faces(f, 1), hull.faces(f, 2))] = f;
  for (const auto& [name, faces] : mesh.surfaces) {
    if (faces.rows() == 0) refuse("surface \"" + name + "\" is empty", "Remove it, or name its faces.");
    if (faces.cols() != hull.faces.cols())
      refuse("surface \"" + name + "\": nodes per face = " + std::to_string(faces.cols()) + "; must be " +
                 std::to_string(hull.faces.cols()),
             "Faces have the order of the cells.");
    std::map<Edge, int> edges;
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
      for (const std::int32_t node : faces.row(f))
        if (node < 0 || node >= mesh.node_count())
          refuse("surface \"" + name + "\": face " + std::to_string(f) + " names node " + std::to_string(node) +
                     "; must be in [0, " + std::to_string(mesh.node_count()) + ")",
                 "Count nodes from 0.");
      const auto found = outside.find(face_key(faces(f, 0), faces(f, 1), faces(f, 2)));
      if (found == outside.end())
        refuse(face_name(mesh, name, f) + " is no boundary face of a cell",
               "Name only faces that belong to exactly one cell; see boundary_of().");
      const auto cell_face = hull.faces.row(found->second);
      int turn = 0;
      while (cell_face[turn] != faces(f, 0)) ++turn;
      if (cell_face[(turn + 1) % 3] != faces(f, 1))
        refuse(face_name(mesh, name, f) + " points into the tissue", "Exchange two of its corners.");
      for (int k = 0; k < 3; ++k) {
        if (faces.cols() == 6 && cell_face[3 + (turn + k) % 3] != faces(f, 3 + k))
          refuse(face_name(mesh, name, f) + " has mid-side node " + std::to_string(faces(f, 3 + k)) +
                     " where its cell has " + std::to_string(cell_face[3 + (turn + k) % 3]),
                 "The order is (0,1) (1,2) (2,0).");
        const Edge ends = edge(faces(f, k), faces(f, (k + 1) % 3));
        if (++edges[ends] > 2)
          refuse("surface \"" + name + "\": more than two faces meet in the edge between " +
                     node_name(mesh, ends[0]) + " and " + node_name(mesh, ends[1]),
                 "Split the surface, remove a face named twice, or give bodies that touch nodes of their own.");
      }
    }
  }
}

/// Differences of coordinates keep what tells a gap from none.
void check_distance(const TetMesh& mesh) {
  constexpr double finest = 1e-6;  // of the shortest edge
  double shortest = std::numeric_limits<double>::infinity();
  for (const auto& cell : mesh.cells.rowwise())
    for (const auto& [a, b] : tet_edges)
      shortest = std::min(shortest, (mesh.points.row(cell[a]) - mesh.points.row(cell[b])).norm());
  Eigen::Index node = 0, axis = 0;
  const double furthest = mesh.points.cwiseAbs().maxCoeff(&node, &axis);
  const double spacing = furthest * std::numeric_limits<double>::epsilon();
  if (shortest > 0 && spacing > finest * shortest)
    throw InvalidInput("TetMesh", std::string("coordinate ") + "xyz"[axis] + " of node " + std::to_string(node),
                       mesh.points(node, axis), "m",
                       "within " + number_text(finest * shortest / std::numeric_limits<double>::epsilon()) +
                           " m of 0, as the shortest edge is " + number_text(shortest) + " m",
                       "Numbers are up to " + number_text(spacing) +
                           " m apart there: what a gap is, is lost. Move the mesh to the origin.");
}

void check_node_sets(const TetMesh& mesh) {
  for (const auto& [name, nodes] : mesh.node_sets) {
    if (nodes.size() == 0) refuse("node set \"" + name + "\" is empty", "Remove it, or name its nodes.");
    for (const std::int32_t node : nodes)
      if (node < 0 || node >= mesh.node_count())
        refuse("node set \"" + name + "\" names node " + std::to_string(node) + "; must be in [0, " +
                   std::to_string(mesh.node_count()) + ")",
               "Count nodes from 0.");
  }
}

}  // namespace

TetMesh labelled(TetMesh mesh) {
  require_size("labelled", "cell_layer", mesh.cell_layer.size(), mesh.cell_count(), 0);
  require_size("labelled", "cell_side", mesh.cell_side.size(), mesh.cell_count(), 0);
  if (mesh.cell_layer.size() == 0 && mesh.layer_names.size() <= 1) {
    mesh.cell_layer = Indices::Zero(mesh.cell_count());
    if (mesh.layer_names.empty()) mesh.layer_names = {"body"};
  }
  if (mesh.cell_side.size() == 0) mesh.cell_side = Indices::Zero(mesh.cell_count());
  return mesh;
}

void check_mesh(const TetMesh& mesh) {
  check_shapes(mesh);
  check_rest(mesh);
  check_indices(mesh);
  check_distance(mesh);
  check_volumes(mesh);
  check_duplicates(mesh);
  check_middles(mesh);
  check_surfaces(mesh);
  check_node_sets(mesh);
}

}  // namespace plica

#include <algorithm>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/mesh/edges.hpp"
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

std::vector<Edge> unique_edges(const Cells& cells) {
  require_size("unique_edges", "a cell", cells.cols(), 4, 10);
  std::vector<Edge> edges;
  edges.reserve(6 * cells.rows());
  for (Eigen::Index e = 0; e < cells.rows(); ++e)
    for (const auto& ends : tet_edges) edges.push_back(edge(cells(e, ends[0]), cells(e, ends[1])));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

TetMesh to_quadratic(const TetMesh& linear) {
  if (linear.cells.cols() != 4)
    throw InvalidInput("to_quadratic", "nodes per cell", static_cast<double>(linear.cells.cols()), "", "4",
                       "Is the mesh quadratic already?");
  if (linear.stretched()) throw InvalidInput("to_quadratic: the mesh is stretched; must be at rest.");
  require_indices("to_quadratic", "node of a cell", linear.cells, linear.node_count());
  for (const auto& [name, faces] : linear.surfaces)
    require_size("to_quadratic", "a face of a surface", faces.cols(), 3);
  for (const auto& [name, nodes] : linear.node_sets)
    require_indices("to_quadratic", "node of a node set", nodes, linear.node_count());
  const std::vector<Edge> edges = unique_edges(linear.cells);
  const Eigen::Index corners = linear.points.rows();
  const auto middle = [&](std::int32_t a, std::int32_t b) {
    const auto place = std::lower_bound(edges.begin(), edges.end(), edge(a, b));
    if (place == edges.end() || *place != edge(a, b))
      throw InvalidInput("to_quadratic: the edge between nodes " + std::to_string(a) + " and " +
                         std::to_string(b) + " of a surface is no edge of a cell. See check_mesh().");
    return static_cast<std::int32_t>(corners + (place - edges.begin()));
  };

  TetMesh mesh = linear;
  mesh.points.conservativeResize(corners + static_cast<Eigen::Index>(edges.size()), 3);
  for (std::size_t i = 0; i < edges.size(); ++i)
    mesh.points.row(corners + i) = 0.5 * (linear.points.row(edges[i][0]) + linear.points.row(edges[i][1]));

  mesh.cells.resize(linear.cells.rows(), 10);
  mesh.cells.leftCols(4) = linear.cells;
  for (Eigen::Index e = 0; e < linear.cells.rows(); ++e)
    for (int k = 0; k < 6; ++k)
      mesh.cells(e, 4 + k) = middle(linear.cells(e, tet_edges[k][0]), linear.cells(e, tet_edges[k][1]));

  for (auto& [name, faces] : mesh.surfaces) {
    const Faces flat = faces;
    faces.resize(flat.rows(), 6);
    faces.leftCols(3) = flat;
    for (Eigen::Index f = 0; f < flat.rows(); ++f)
      for (int k = 0; k < 3; ++k) faces(f, 3 + k) = middle(flat(f, k), flat(f, (k + 1) % 3));
  }
  for (auto& [name, nodes] : mesh.node_sets) {
    std::vector<char> inside(corners, 0);
    for (const std::int32_t node : nodes) inside[node] = 1;
    std::vector<std::int32_t> all(nodes.begin(), nodes.end());
    for (std::size_t i = 0; i < edges.size(); ++i)
      if (inside[edges[i][0]] && inside[edges[i][1]]) all.push_back(static_cast<std::int32_t>(corners + i));
    nodes = Eigen::Map<const Indices>(all.data(), static_cast<Eigen::Index>(all.size()));
  }
  return mesh;
}

}  // namespace plica

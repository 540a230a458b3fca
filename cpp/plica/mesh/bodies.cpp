#include <algorithm>
#include <numeric>

#include "plica/core/require.hpp"
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

Indices body_of_nodes(const TetMesh& mesh) {
  require_indices("body_of_nodes", "node of a cell", mesh.cells, mesh.node_count());
  Indices body(mesh.node_count());
  std::iota(body.begin(), body.end(), 0);
  const auto root = [&](std::int32_t node) {
    while (body[node] != node) node = body[node] = body[body[node]];
    return node;
  };
  for (Eigen::Index e = 0; e < mesh.cell_count(); ++e)
    for (Eigen::Index k = 1; k < mesh.cells.cols(); ++k) {
      const std::int32_t a = root(mesh.cells(e, 0)), b = root(mesh.cells(e, k));
      body[std::max(a, b)] = std::min(a, b);
    }
  for (std::int32_t node = 0; node < body.size(); ++node) body[node] = root(node);
  return body;
}

}  // namespace plica

#include "plica/mesh/block.hpp"

#include <cmath>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/mesh/structured.hpp"

namespace plica {

void Block::validate() const {
  static const char* const axes[] = {"x", "y", "z"};
  for (int d = 0; d < 3; ++d) {
    const std::string axis = axes[d];
    if (!std::isfinite(corner[d])) throw InvalidInput("Block", "corner." + axis, corner[d], "m", "finite");
    if (!(size[d] > 0) || !std::isfinite(size[d]))
      throw InvalidInput("Block", "size." + axis, size[d], "m", "> 0");
    if (divisions[d] < 1) throw InvalidInput("Block", "divisions." + axis, divisions[d], "", ">= 1");
  }
  const double nodes = (divisions[0] + 1.0) * (divisions[1] + 1.0) * (divisions[2] + 1.0);
  if (nodes > 5e7) throw InvalidInput("Block", "nodes", nodes, "", "<= 5e7", "Fewer divisions are needed.");
}

TetMesh block_mesh(const Block& block) {
  block.validate();
  const auto [nx, ny, nz] = block.divisions;
  const auto node = [nx = nx, ny = ny](int i, int j, int k) { return (k * (ny + 1) + j) * (nx + 1) + i; };

  TetMesh mesh;
  mesh.layer_names = {"body"};
  mesh.points.resize(node(nx, ny, nz) + 1, 3);
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        mesh.points.row(node(i, j, k)) << block.corner[0] + block.size[0] * i / nx,
            block.corner[1] + block.size[1] * j / ny, block.corner[2] + block.size[2] * k / nz;

  // Two prisms to a hexahedron; the key is the node number.
  std::vector<std::array<std::int32_t, 4>> cells;
  const auto prism = [&](std::array<std::int32_t, 6> n) {
    split_prism({{{n[0], n[0]}, {n[1], n[1]}, {n[2], n[2]}, {n[3], n[3]}, {n[4], n[4]}, {n[5], n[5]}}}, cells);
  };
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        const auto at = [&](int a, int b, int c) { return node(i + a, j + b, k + c); };
        prism({at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 0, 1), at(1, 0, 1), at(1, 1, 1)});
        prism({at(0, 0, 0), at(1, 1, 0), at(0, 1, 0), at(0, 0, 1), at(1, 1, 1), at(0, 1, 1)});
      }
  mesh.cells = as_cells(cells);
  mesh.cell_layer = Indices::Zero(mesh.cell_count());
  mesh.cell_side = Indices::Zero(mesh.cell_count());

  const Boundary hull = boundary_of(mesh.cells);
  static const char* const names[3][2] = {{"x_min", "x_max"}, {"y_min", "y_max"}, {"z_min", "z_max"}};
  for (int d = 0; d < 3; ++d)
    for (int end = 0; end < 2; ++end) {
      std::vector<char> marked(mesh.node_count(), 0);
      std::vector<std::int32_t> nodes;
      for (int k = 0; k <= nz; ++k)
        for (int j = 0; j <= ny; ++j)
          for (int i = 0; i <= nx; ++i) {
            const int place[3] = {i, j, k};
            if (place[d] != (end ? block.divisions[d] : 0)) continue;
            nodes.push_back(node(i, j, k));
            marked[nodes.back()] = 1;
          }
      mesh.node_sets[names[d][end]] =
          Eigen::Map<const Indices>(nodes.data(), static_cast<Eigen::Index>(nodes.size()));
      mesh.surfaces[names[d][end]] = marked_faces(hull, marked);
    }
  return mesh;
}

TetMesh combine_meshes(const TetMesh& one, const TetMesh& other, const std::string& first_prefix,
                       const std::string& second_prefix) {
  const TetMesh first = labelled(one), second = labelled(other);
  if (first.order() != second.order())
    throw InvalidInput("combine", "order of the second mesh", second.order(), "",
                       "that of the first, " + std::to_string(first.order()),
                       "Apply to_quadratic to the other one.");
  if (first_prefix == second_prefix)
    throw InvalidInput("combine: second_prefix = \"" + second_prefix + "\"; must differ from first_prefix.");
  for (const TetMesh* mesh : {&first, &second})
    require_size("combine_meshes", "cell_layer, which several layers need", mesh->cell_layer.size(),
                 mesh->cell_count());
  require_size("combine_meshes", "a row of the second mesh's cells", second.cells.cols(), first.cells.cols());
  const auto nodes = static_cast<std::int32_t>(first.node_count());
  const auto layers = static_cast<std::int32_t>(first.layer_names.size());
  TetMesh mesh;
  mesh.points.resize(first.node_count() + second.node_count(), 3);
  mesh.points << first.points, second.points;
  mesh.cells.resize(first.cell_count() + second.cell_count(), first.cells.cols());
  mesh.cells << first.cells, (second.cells.array() + nodes).matrix();
  mesh.cell_layer.resize(mesh.cell_count());
  mesh.cell_layer << first.cell_layer, (second.cell_layer.array() + layers).matrix();
  mesh.cell_side.resize(mesh.cell_count());
  mesh.cell_side << first.cell_side, second.cell_side;
  for (const auto& name : first.layer_names) mesh.layer_names.push_back(first_prefix + name);
  for (const auto& name : second.layer_names) mesh.layer_names.push_back(second_prefix + name);
  for (const auto& [name, faces] : first.surfaces) mesh.surfaces[first_prefix + name] = faces;
  for (const auto& [name, faces] : second.surfaces) mesh.surfaces[second_prefix + name] = faces.array() + nodes;
  for (const auto& [name, set] : first.node_sets) mesh.node_sets[first_prefix + name] = set;
  for (const auto& [name, set] : second.node_sets) mesh.node_sets[second_prefix + name] = set.array() + nodes;
  return mesh;
}

}  // namespace plica

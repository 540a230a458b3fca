#pragma once
#include <array>

#include "plica/mesh/tet_mesh.hpp"

namespace plica {

/// A box [corner, corner + size] of linear tetrahedra, six to a hexahedron, all faces conforming.
/// Surfaces and node sets "x_min", "x_max", "y_min", ... are its six sides. One layer, "body".
struct Block {
  std::array<double, 3> corner{0, 0, 0};  // m
  std::array<double, 3> size{1, 1, 1};    // m, > 0
  std::array<int, 3> divisions{1, 1, 1};  // >= 1
  void validate() const;
};
TetMesh block_mesh(const Block& block);

/// Two meshes side by side as one (no node is joined). Surfaces, node sets and layers keep their names
/// with `first_prefix` / `second_prefix` before them; e.g. "a." and "b." give "a.x_max", "b.x_min".
TetMesh combine_meshes(const TetMesh& first, const TetMesh& second, const std::string& first_prefix,
                       const std::string& second_prefix);

}  // namespace plica

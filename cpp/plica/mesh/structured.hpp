#pragma once
#include <array>

#include "plica/mesh/tet_mesh.hpp"

namespace plica {

/// A corner of a structured prism: its node, and the key that decides where its quads are cut.
struct PrismCorner {
  std::int32_t node;
  std::int64_t key;
};

/// Appends the three tetrahedra of the prism with base 0 1 2, counter-clockwise seen from 3 4 5 above it;
/// they are positive. Each quad is cut at its corner of smallest key, so prisms that share a quad agree;
/// the six keys must differ, then no choice is cyclic.
void split_prism(const std::array<PrismCorner, 6>& prism, std::vector<std::array<std::int32_t, 4>>& cells);

/// The tetrahedra as an array.
Cells as_cells(const std::vector<std::array<std::int32_t, 4>>& cells);

/// The boundary faces whose corners are all marked.
Faces marked_faces(const Boundary& boundary, const std::vector<char>& marked);

}  // namespace plica

#pragma once
#include <array>
#include <cstdint>
#include <utility>

#include "plica/core/types.hpp"

namespace plica {

/// The ends of the six edges of a tetrahedron, in the order of its mid-side nodes 4 ... 9.
inline constexpr std::array<std::array<int, 2>, 6> tet_edges{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
/// The four outward faces of a positive tetrahedron: corners, then mid-side nodes (0,1) (1,2) (2,0).
inline constexpr std::array<std::array<int, 6>, 4> tet_faces{
    {{0, 2, 1, 6, 5, 4}, {0, 1, 3, 4, 8, 7}, {1, 2, 3, 5, 9, 8}, {0, 3, 2, 7, 9, 6}}};

/// Two node numbers, the smaller one first.
using Edge = std::array<std::int32_t, 2>;
inline Edge edge(std::int32_t a, std::int32_t b) { return a < b ? Edge{a, b} : Edge{b, a}; }

/// Three corner numbers of a face, ascending.
using FaceKey = std::array<std::int32_t, 3>;
inline FaceKey face_key(std::int32_t a, std::int32_t b, std::int32_t c) {
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  return {a, b, c};
}

/// Every edge between corners once, ascending; its place is its number. O(m log m).
std::vector<Edge> unique_edges(const Cells& cells);

}  // namespace plica

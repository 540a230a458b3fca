#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "plica/solve/ordering.hpp"

namespace plica {

/// The columns of a Cholesky factor, gathered to supernodes: runs of columns that share the rows below. Positions
/// count nodes in the order of elimination. A supernode comes after those below it in the tree.
struct Supernodes {
  Order order;                       // node at each position
  std::vector<std::int32_t> first;   // (count + 1) position of each supernode's first column
  std::vector<std::int32_t> parent;  // (count) the supernode of the first row below; -1 where there is none
  std::vector<std::vector<std::int32_t>> children;  // (count) ascending
  std::vector<std::ptrdiff_t> row_start;            // (count + 1)
  std::vector<std::int32_t> row;                    // positions of the rows below, ascending
  std::vector<std::int32_t> place;         // of these rows in the parent: its columns first, then its rows
  std::vector<std::int32_t> supernode_of;  // of each position

  std::int32_t count() const { return static_cast<std::int32_t>(parent.size()); }
  std::int32_t columns(std::int32_t s) const {
    const auto at = static_cast<std::size_t>(s);
    return first[at + 1] - first[at];
  }
  std::int32_t rows(std::int32_t s) const {
    const auto at = static_cast<std::size_t>(s);
    return static_cast<std::int32_t>(row_start[at + 1] - row_start[at]);
  }
  std::ptrdiff_t floats() const;  // that the factor takes
};

/// Columns and rows of 3 unknowns a node are stored in tiles of 8 x 8.
constexpr std::ptrdiff_t tile = 8;
constexpr std::ptrdiff_t padded(std::ptrdiff_t nodes) { return (3 * nodes + tile - 1) / tile * tile; }
/// Numbers in the tiles of so many columns and rows below.
constexpr std::ptrdiff_t panel_floats(std::ptrdiff_t columns, std::ptrdiff_t rows) {
  const std::ptrdiff_t wide = padded(columns);
  return wide * (wide + tile) / 2 + wide * padded(rows);
}

/// The supernodes of the symmetric graph eliminated in this order. A supernode joins its parent where streaming
/// the zeros that this stores takes less time than a supernode of its own. O(blocks of the factor).
Supernodes supernodes(const NodePattern& graph, const Order& order);

}  // namespace plica

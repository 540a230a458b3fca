#pragma once
#include <cstdint>
#include <vector>

namespace plica {

/// A symmetric graph without loops, in compressed rows.
struct Graph {
  std::vector<std::int32_t> start{0};      // (n + 1)
  std::vector<std::int32_t> neighbour;     // (edges, both ways)
  std::vector<std::int32_t> multiplicity;  // (edges, both ways) edges of the finest graph that lie in this one
  std::vector<std::int32_t> weight;        // (n) nodes of the finest graph that lie in this one

  std::int32_t size() const { return static_cast<std::int32_t>(weight.size()); }
};

enum class Half : std::uint8_t { left, right, separator };

/// Divides a graph in two sides that no edge joins and a separator between them, which is made small while
/// neither side exceeds 55 % of the weight. O(edges log n).
std::vector<Half> bisect(const Graph& graph);

}  // namespace plica

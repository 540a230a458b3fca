#include "plica/estimation/node_order.hpp"

#include <algorithm>

namespace plica {
namespace {

/// Appends the nodes reached from `start`, level by level, of a level's those of least degree first.
void walk(const NodePattern& graph, std::int32_t start, std::vector<char>& seen, Order& order) {
  const auto degree = [&](std::int32_t i) { return graph.row_start[i + 1] - graph.row_start[i]; };
  std::size_t next = order.size();
  order.push_back(start);
  seen[start] = 1;
  for (; next < order.size(); ++next) {
    const std::int32_t node = order[next];
    const auto from = static_cast<std::ptrdiff_t>(order.size());
    for (std::int32_t e = graph.row_start[node]; e < graph.row_start[node + 1]; ++e) {
      const std::int32_t other = graph.column[e];
      if (seen[other]) continue;
      seen[other] = 1;
      order.push_back(other);
    }
    std::sort(order.begin() + from, order.end(), [&](std::int32_t a, std::int32_t b) {
      return degree(a) != degree(b) ? degree(a) < degree(b) : a < b;
    });
  }
}

}  // namespace

Order near_neighbours(const NodePattern& graph) {
  const auto nodes = static_cast<std::int32_t>(graph.rows());
  Order order;
  std::vector<char> seen(static_cast<std::size_t>(nodes), 0);
  for (std::int32_t i = 0; i < nodes; ++i) {
    if (seen[i]) continue;
    const std::size_t from = order.size();
    std::int32_t start = i;
    for (int pass = 0; pass < 3; ++pass) {  // the last node of a walk is at an end
      if (pass > 0) {
        start = order.back();
        for (std::size_t k = from; k < order.size(); ++k) seen[order[k]] = 0;
        order.resize(from);
      }
      walk(graph, start, seen, order);
    }
  }
  return order;
}

}  // namespace plica

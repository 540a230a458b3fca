#include "plica/solve/ordering.hpp"

#include <Eigen/OrderingMethods>
#include <algorithm>

#include "plica/solve/bisection.hpp"

namespace plica {
namespace {

/// The part of a graph that the given nodes span, numbered as in the list. `local` (all nodes): -1 before and
/// after.
Graph part_of(const NodePattern& graph, const Order& nodes, std::vector<std::int32_t>& local) {
  Graph part;
  for (std::size_t i = 0; i < nodes.size(); ++i) local[nodes[i]] = static_cast<std::int32_t>(i);
  for (const std::int32_t v : nodes) {
    for (std::int32_t e = graph.row_start[v]; e < graph.row_start[v + 1]; ++e) {
      const std::int32_t u = graph.column[e];
      if (u != v && local[u] >= 0) part.neighbour.push_back(local[u]);
    }
    part.start.push_back(static_cast<std::int32_t>(part.neighbour.size()));
  }
  part.weight.assign(nodes.size(), 1);
  part.multiplicity.assign(part.neighbour.size(), 1);
  for (const std::int32_t v : nodes) local[v] = -1;
  return part;
}

Order minimum_degree(const Graph& graph) {
  const std::int32_t n = graph.size();
  // With its diagonal: Eigen takes a node without one for dense.
  Eigen::SparseMatrix<double, Eigen::ColMajor, std::int32_t> pattern(n, n);
  pattern.reserve(static_cast<std::ptrdiff_t>(graph.neighbour.size()) + n);
  for (std::int32_t v = 0; v < n; ++v) {
    pattern.startVec(v);
    bool before = true;
    for (std::int32_t e = graph.start[v]; e <= graph.start[v + 1]; ++e) {
      const std::int32_t u = e < graph.start[v + 1] ? graph.neighbour[e] : n;
      if (before && u > v) pattern.insertBack(v, v) = 1.0, before = false;
      if (u < n) pattern.insertBack(u, v) = 1.0;
    }
  }
  pattern.finalize();
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, std::int32_t> permutation;
  Eigen::AMDOrdering<std::int32_t>()(pattern, permutation);
  return {permutation.indices().data(), permutation.indices().data() + n};
}

/// The connected parts of a graph, each a list of its nodes.
std::vector<Order> components(const Graph& graph) {
  std::vector<Order> parts;
  std::vector<std::uint8_t> seen(graph.weight.size(), 0);
  for (std::int32_t root = 0; root < graph.size(); ++root) {
    if (seen[root]) continue;
    Order part{root};
    seen[root] = 1;
    for (std::size_t at = 0; at < part.size(); ++at) {
      for (std::int32_t e = graph.start[part[at]]; e < graph.start[part[at] + 1]; ++e) {
        const std::int32_t u = graph.neighbour[e];
        if (!seen[u]) seen[u] = 1, part.push_back(u);
      }
    }
    std::sort(part.begin(), part.end());
    parts.push_back(std::move(part));
  }
  return parts;
}

class Dissection {
 public:
  explicit Dissection(const NodePattern& graph)
      : graph_(graph), local_(static_cast<std::size_t>(graph.rows()), -1) {}

  /// Appends the nodes: both sides, then the separator.
  void append(const Order& nodes) {
    constexpr std::size_t leaf = 100;  // below, minimum degree fills no more
    const Graph part = part_of(graph_, nodes, local_);
    const auto chosen = [&](const Order& places) {
      Order list;
      for (const std::int32_t place : places) list.push_back(nodes[place]);
      return list;
    };
    const auto finish = [&](const Order& places) {
      for (const std::int32_t place : places) order.push_back(nodes[place]);
    };
    if (nodes.size() <= leaf) return finish(minimum_degree(part));
    const std::vector<Order> connected = components(part);
    if (connected.size() > 1) {
      for (const Order& places : connected) append(chosen(places));
      return;
    }
    const std::vector<Half> half = bisect(part);
    std::array<Order, 3> places;
    for (std::int32_t v = 0; v < part.size(); ++v) places[static_cast<int>(half[v])].push_back(v);
    if (places[0].empty() || places[1].empty()) return finish(minimum_degree(part));  // nearly complete: no gap
    append(chosen(places[0]));
    append(chosen(places[1]));
    finish(places[2]);
  }

  Order order;

 private:
  const NodePattern& graph_;
  std::vector<std::int32_t> local_;
};

Order all_nodes(const NodePattern& graph) {
  Order nodes(static_cast<std::size_t>(graph.rows()));
  for (std::size_t v = 0; v < nodes.size(); ++v) nodes[v] = static_cast<std::int32_t>(v);
  return nodes;
}

}  // namespace

Order minimum_degree(const NodePattern& graph) {
  std::vector<std::int32_t> local(static_cast<std::size_t>(graph.rows()), -1);
  return minimum_degree(part_of(graph, all_nodes(graph), local));
}

Order nested_dissection(const NodePattern& graph) {
  Dissection dissection(graph);
  dissection.append(all_nodes(graph));
  return std::move(dissection.order);
}

}  // namespace plica

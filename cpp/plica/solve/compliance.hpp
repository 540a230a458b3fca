#pragma once
#include "plica/solve/krylov.hpp"

namespace plica {

/// Columns of A^-1 for single unknowns, restricted to chosen nodes, computed when first asked for and kept.
/// Row r of a column belongs to unknown 3 * nodes[r / 3] + r % 3. Deterministic: a column does not depend on
/// when, or with which others, it was computed.
class Compliance {
 public:
  /// nodes: the nodes that results are wanted at and that columns may be asked for. Fixed unknowns have
  /// zero columns. Column tolerance is that of `solver`'s options given here.
  Compliance(const BlockMatrix& A, const class Supports& supports, Indices nodes, KrylovOptions options);

  const Indices& nodes() const { return nodes_; }
  /// Makes sure that the three columns of each of these nodes (positions in nodes()) exist.
  void require(const std::vector<std::int32_t>& local_nodes);
  bool has(std::int32_t local_node) const;
  /// (3 nodes) displacement of all nodes under a unit force on component c of a node; must exist.
  const double* column(std::int32_t local_node, int component) const;
  std::ptrdiff_t column_count() const;
};

}  // namespace plica

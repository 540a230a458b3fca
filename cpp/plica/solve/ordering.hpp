#pragma once
#include "plica/core/block_matrix.hpp"

namespace plica {

/// An order of elimination: its k-th entry is the node eliminated as the k-th.
using Order = std::vector<std::int32_t>;

/// Orders of a symmetric graph for a sparse Cholesky factorisation, both deterministic: the approximate minimum
/// degree of Amestoy, Davis and Duff (1996; Eigen's), and nested dissection (George 1973) with bisections found
/// on a hierarchy of matched graphs and refined by moving nodes of the separator (Fiduccia and Mattheyses 1982;
/// Hendrickson and Rothberg 1998).
Order minimum_degree(const NodePattern& graph);
Order nested_dissection(const NodePattern& graph);

}  // namespace plica

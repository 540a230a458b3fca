#pragma once
#include "plica/solve/ordering.hpp"

namespace plica {

/// The order of Cuthill and McKee (1969), from a node at an end of the graph: neighbours come near each other, so
/// that a product with many vectors finds them in cache. Its k-th entry is the node that is numbered k.
/// O(entries).
Order near_neighbours(const NodePattern& graph);

}  // namespace plica

#pragma once
#include <optional>

#include "plica/core/types.hpp"

namespace plica {

/// One of `nodes` that at positions x (n, 3) lies inside a cell, by more than the fraction `deep` of the cell's
/// heights; corners of the cells only. A brute-force test, for once: O(cells log nodes + cells x nodes in their
/// reach of x).
std::optional<std::int32_t> node_in_tissue(const Points& x, const Cells& cells, const Indices& nodes, double deep);

}  // namespace plica

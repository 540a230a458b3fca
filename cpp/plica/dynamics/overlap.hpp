#pragma once
#include <optional>

#include "plica/core/types.hpp"

namespace plica {

/// One of `nodes` that at positions x (n, 3) lies in a cell that it is no node of, further from the tissue's
/// boundary than the fraction `deep` of the cell's height there; corners of the cells only. A brute-force test,
/// for once: O(cells log cells + cells x nodes in their range of x).
std::optional<std::int32_t> node_in_tissue(const Points& x, const Cells& cells, const Indices& nodes, double deep);

}  // namespace plica

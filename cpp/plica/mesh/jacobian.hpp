#pragma once
#include "plica/core/types.hpp"

namespace plica {

/// Of each cell the least Bezier coefficient of det dx/dxi over 6 V of its corners: 1 where sides are straight,
/// and nowhere in the cell is det dx/dxi / (6 V) less (Johnen, Remacle and Geuzaine 2013). O(m).
Vector least_jacobian_ratios(const Points& x, const Cells& cells);

}  // namespace plica

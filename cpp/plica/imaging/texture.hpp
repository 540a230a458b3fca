#pragma once
#include "plica/core/types.hpp"

namespace plica::imaging {

/// Values of a periodic cube of samples at places in units of its spacing, by splines.
/// tile (n^3), the last index fastest; places (p, 3) in the order of its indices; degree 1, or 3: then the tile
/// has the coefficients of cubic B-splines.
Vector periodic_spline(const Eigen::Ref<const Vector>& tile, std::ptrdiff_t n, const Points& places, int degree);

}  // namespace plica::imaging

#pragma once
#include "plica/imaging/plane.hpp"

namespace plica::imaging {

/// The median of the 5 x 5 pixels about each pixel, symmetric borders. `result` is another plane of the same size.
void median_5x5(const Plane& image, Plane& result);

}  // namespace plica::imaging

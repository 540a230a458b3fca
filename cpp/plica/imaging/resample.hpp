#pragma once
#include <vector>

#include "plica/imaging/plane.hpp"

namespace plica::imaging {

/// Gaussian filter with standard deviation sigma (px) and half-width round(1.5 sigma), symmetric borders.
Plane blur(const Plane& image, double sigma);

/// Linear interpolation to another size; the outer edges of the pictures coincide, so that pixel i of the
/// result lies at (i + 1/2) n_in / n_out - 1/2.
Plane resize(const Plane& image, std::ptrdiff_t rows, std::ptrdiff_t columns);

/// The picture, then each time blurred by sqrt(spacing / 2) px and made smaller by `spacing`: finest first.
std::vector<Plane> pyramid(Plane image, int levels, double spacing);

}  // namespace plica::imaging

#pragma once
#include <array>

#include "plica/imaging/plane.hpp"
#include "plica/imaging/spline.hpp"

namespace plica::imaging {

/// How the light changes from a picture to the next: what has the grey I at x in the first has
/// gain(x) I + offset in the second, docs/imaging.md, "Light that changes".
struct Light {
  /// Of 1, x, y, x^2, x y, y^2, with x and y from -1 at the one border of the picture to 1 at the other.
  std::array<double, 6> gain{1, 0, 0, 0, 0, 0};
  double offset = 0;  // grey levels

  /// gain(x) at each pixel of a picture of this size.
  Plane gains(std::ptrdiff_t rows, std::ptrdiff_t columns) const;
};

/// The light from `first` to second(x + u, y + v), by robust least squares over means of square blocks of pixels.
/// Left out are pixels that `used` leaves out (empty: none), those that leave the picture, and the brightest 2 %
/// of either's range, where a camera may be saturated. With fewer than 1000 blocks the gain is one number and
/// there is no offset.
Light fit_light(const Plane& first, const Plane& second, const Spline& spline, const Plane& used, const Plane& u,
                const Plane& v);

/// Both pictures in the light of the first, cut where either camera may be saturated: the first at
/// (max second - offset) / gain, (second - offset) / gain at max first.
struct Relit {
  Plane first, second;
};
Relit relight(const Plane& first, const Plane& second, const Light& light);

}  // namespace plica::imaging

#pragma once
#include "plica/imaging/flow.hpp"
#include "plica/imaging/flow_system.hpp"
#include "plica/imaging/spline.hpp"

namespace plica::imaging {

/// The data term about the flow (u, v): `it` = second(x + u, y + v) - first, and the derivatives
/// [1 -8 0 8 -1] / 12 of the mean of the two. `trust` is `used` where (x + u, y + v) lies in the picture, else 0;
/// an empty `used` is 1 everywhere.
void linearise(const Plane& first, const Spline& second, const Plane& used, const Plane& u, const Plane& v,
               Linearisation& result);

/// Divides the channel by sqrt(ix^2 + iy^2 + noise^2): where the slope is well above `noise` its error is then a
/// distance (px) along it.
void normalise(float noise, Linearisation& channel);

/// The derivatives of a picture by [1 -8 0 8 -1] / 12, grey levels per px.
struct Gradient {
  Plane x, y;
};
Gradient gradient(const Plane& image);

/// second(x + u, y + v) - first; not a number where (x + u, y + v) lies outside the picture.
Plane residual(const Plane& first, const Plane& second, const Plane& u, const Plane& v);

/// Where (px) one lands from the start after going there and back: f(x) + b(x + f(x)), b interpolated linearly;
/// not a number where x + f(x) lies outside the picture.
Flow round_trip(const Flow& forward, const Flow& backward);

}  // namespace plica::imaging

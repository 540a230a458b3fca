#include <doctest/doctest.h>

#include "../approx.hpp"
#include "pictures.hpp"
#include "plica/imaging/spline.hpp"

using namespace plica;
using namespace plica::imaging;

namespace {

/// The spline of an image at (x + u, y + v) for all pixels.
struct Warped {
  Plane values, inside;

  Warped(const Plane& image, float u, float v)
      : values(image.rows(), image.cols()), inside(image.rows(), image.cols()) {
    const Spline spline(image);
    const Plane all_u = Plane::Constant(image.rows(), image.cols(), u),
                all_v = Plane::Constant(image.rows(), image.cols(), v);
    for (std::ptrdiff_t y = 0; y < image.rows(); ++y)
      spline.warp_row(y, all_u, all_v, values.row(y), inside.row(y));
  }
};

}  // namespace

TEST_CASE("the spline goes through the pixels") {
  const std::ptrdiff_t sizes[][2] = {{40, 33}, {8, 9}, {2, 3}};
  for (const auto& size : sizes) {
    const Plane image = noise(size[0], size[1], 100, 3);
    const Warped warped(image, 0, 0);
    CHECK((warped.values - image).abs().maxCoeff() < 1e-4);  // round-off of 100
    CHECK(warped.inside.minCoeff() == 1);
  }
}

TEST_CASE("the spline is exact on cubics away from the border") {
  const auto cubic = [](double x, double y) {
    const double s = x / 20 - 1, t = y / 20 - 1;
    return 1 + s - 2 * t + s * s * t - 3 * s * s * s + 2 * t * t * t + s * s * s * t * t * t;
  };
  Plane image(48, 48);
  for (std::ptrdiff_t y = 0; y < 48; ++y) {
    for (std::ptrdiff_t x = 0; x < 48; ++x) {
      image(y, x) = static_cast<float>(cubic(static_cast<double>(x), static_cast<double>(y)));
    }
  }
  for (const float u : {-2.75F, 0.3F, 1.999F}) {
    const float v = 0.6F - u;
    const Warped warped(image, u, v);
    double worst = 0;
    for (std::ptrdiff_t y = 16; y < 32; ++y) {  // the border's influence falls by 0.27 a pixel
      for (std::ptrdiff_t x = 16; x < 32; ++x) {
        worst = std::max(worst,
                         std::abs(warped.values(y, x) - cubic(static_cast<double>(x) + static_cast<double>(u),
                                                              static_cast<double>(y) + static_cast<double>(v))));
      }
    }
    CHECK(worst < 2e-6);
  }
}

TEST_CASE("places outside are told and take the nearest value inside") {
  const Plane image = noise(20, 30, 1, 4);
  const Warped to_right(image, 5.5F, 0), up(image, 0, -3), far(image, 1e30F, -1e30F);
  for (std::ptrdiff_t y = 0; y < 20; ++y) {
    for (std::ptrdiff_t x = 0; x < 30; ++x) {
      CHECK(to_right.inside(y, x) == (x + 5.5 <= 29 ? 1 : 0));
      CHECK(up.inside(y, x) == (y >= 3 ? 1 : 0));
    }
    CHECK(to_right.values(y, 29) == approx(image(y, 29)).epsilon(1e-5));
  }
  CHECK(far.inside.maxCoeff() == 0);
  CHECK(far.values(7, 7) == approx(image(0, 29)).epsilon(1e-5));
  const Warped to_last(image.leftCols(8), 0, 0);
  CHECK(to_last.inside.minCoeff() == 1);
}

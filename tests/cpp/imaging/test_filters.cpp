#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "../approx.hpp"
#include "pictures.hpp"
#include "plica/imaging/median.hpp"
#include "plica/imaging/resample.hpp"

using namespace plica;
using namespace plica::imaging;

TEST_CASE("the median is that of sorting, at the border too") {
  const std::ptrdiff_t sizes[][2] = {{30, 41}, {8, 8}, {1, 1}, {3, 2}};
  for (const auto& size : sizes) {
    Plane image = noise(size[0], size[1], 3, 5);
    image = image.round() + 0.0F;  // with many ties
    for (const Plane& tested : {noise(size[0], size[1], 1, 6), image}) {
      Plane result;
      median_5x5(tested, result);
      for (std::ptrdiff_t y = 0; y < tested.rows(); ++y) {
        for (std::ptrdiff_t x = 0; x < tested.cols(); ++x) {
          std::vector<float> window;
          for (std::ptrdiff_t j = -2; j <= 2; ++j) {
            for (std::ptrdiff_t i = -2; i <= 2; ++i) {
              window.push_back(tested(mirrored(y + j, tested.rows()), mirrored(x + i, tested.cols())));
            }
          }
          std::nth_element(window.begin(), window.begin() + 12, window.end());
          REQUIRE(result(y, x) == window[12]);
        }
      }
    }
  }
}

TEST_CASE("blurring keeps a constant and, away from the border, a ramp") {
  Plane ramp(20, 24);
  for (std::ptrdiff_t y = 0; y < 20; ++y) {
    for (std::ptrdiff_t x = 0; x < 24; ++x) ramp(y, x) = static_cast<float>(2 * x - 3 * y);
  }
  const Plane smooth = blur(ramp, 1.0);
  CHECK((smooth - ramp).block(2, 2, 16, 20).abs().maxCoeff() < 1e-4);
  CHECK((blur(Plane::Constant(5, 4, 7), 1.4) - 7).abs().maxCoeff() < 1e-5);
  CHECK(smooth(10, 0) > ramp(10, 0));  // the symmetric border
}

TEST_CASE("blurring twice adds the variances") {
  const Plane spot = [] {
    Plane image = Plane::Zero(41, 41);
    image(20, 20) = 1;
    return image;
  }();
  const Plane spread = blur(blur(spot, 1.0), 1.0);
  double variance = 0;
  for (std::ptrdiff_t x = 0; x < 41; ++x)
    variance += static_cast<double>(spread.col(x).sum()) * (x - 20.0) * (x - 20.0);
  CHECK(spread.sum() == approx(1).epsilon(1e-5));
  CHECK(variance == approx(2 * 0.9243).epsilon(1e-3));  // 5 taps: sum k^2 g / sum g
}

TEST_CASE("resizing keeps the place of a ramp") {
  // A place has the coordinate (i + 1/2) / n in every picture.
  Plane ramp(3, 40);
  for (std::ptrdiff_t x = 0; x < 40; ++x) ramp.col(x) = (static_cast<float>(x) + 0.5F) / 40;
  for (const std::ptrdiff_t columns : {20, 25, 32, 57}) {
    const Plane other = resize(ramp, 7, columns);
    for (std::ptrdiff_t x = 2; x + 2 < columns; ++x) {
      CHECK(other(3, x) == approx((static_cast<double>(x) + 0.5) / static_cast<double>(columns)).epsilon(1e-5));
    }
  }
  CHECK((resize(ramp, 3, 40) == ramp).all());
}

TEST_CASE("a pyramid's levels have the sizes rounded up") {
  const auto levels = pyramid(noise(33, 50, 1, 1), 3, 2);
  REQUIRE(levels.size() == 3);
  CHECK(levels[1].rows() == 17);
  CHECK(levels[1].cols() == 25);
  CHECK(levels[2].rows() == 9);
  CHECK(levels[2].cols() == 13);
}

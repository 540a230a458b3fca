#include <doctest/doctest.h>

#include "../approx.hpp"
#include "pictures.hpp"
#include "plica/imaging/flow.hpp"
#include "plica/imaging/light.hpp"

using namespace plica;
using namespace plica::imaging;

namespace {

constexpr std::ptrdiff_t rows = 150, columns = 190;

Light lamp() {
  Light light;
  light.gain = {1.06, 0.03, -0.02, 0.015, 0.01, -0.02};
  light.offset = 4;
  return light;
}

Plane under(const Light& light, const Plane& picture) {
  return light.gains(picture.rows(), picture.cols()) * picture + static_cast<float>(light.offset);
}

Light fitted(const Plane& first, const Plane& second, const Plane& used = {}) {
  const Plane still = Plane::Zero(first.rows(), first.cols());
  return fit_light(first, second, Spline(second), used, still, still);
}

/// Largest difference of two lights over all pixels of grey 0 to 255.
double apart(const Light& one, const Light& other) {
  const Plane difference = one.gains(rows, columns) - other.gains(rows, columns);
  return std::max(std::abs(one.offset - other.offset),
                  std::abs(255.0 * static_cast<double>(difference.abs().maxCoeff()) + one.offset - other.offset));
}

double error(const Flow& flow, float u, float v) {
  const auto inner = ((flow.u - u).square() + (flow.v - v).square()).sqrt();
  return static_cast<double>(inner.block(12, 12, flow.u.rows() - 24, flow.u.cols() - 24).mean());
}

}  // namespace

TEST_CASE("the gain at a pixel is its polynomial in the place from border to border") {
  const Light light = lamp();
  const Plane gains = light.gains(4, 8);
  const double x = 2 * 6.5 / 8 - 1, y = 2 * 1.5 / 4 - 1;
  const auto& c = light.gain;
  const double expected = c[0] + c[1] * x + c[2] * y + c[3] * x * x + c[4] * x * y + c[5] * y * y;
  CHECK(gains(1, 6) == approx(expected).epsilon(1e-6));
}

TEST_CASE("a gain that varies over the picture and an offset are found, whatever a seventh of it does") {
  const Plane first = Texture().picture(rows, columns);
  Plane second = under(lamp(), first);
  CHECK(apart(Light{}, lamp()) > 10);
  CHECK(apart(fitted(first, second), lamp()) < 0.1);
  second.block(20, 30, 60, 70) = 0.5F * second.block(40, 90, 60, 70).eval();  // another thing stands there
  CHECK(apart(fitted(first, second), lamp()) < 1);
  Plane used = Plane::Ones(rows, columns);
  used.block(18, 28, 64, 74) = 0;
  CHECK(apart(fitted(first, second, used), lamp()) < 0.1);
}

TEST_CASE("pictures without a light to tell leave it as it is") {
  const Plane black = Plane::Zero(rows, columns), plain = Plane::Constant(rows, columns, 90);
  for (const Plane* picture : {&black, &plain}) {
    const Light light = fitted(*picture, *picture);
    CHECK(light.gain == Light{}.gain);
    CHECK(light.offset == 0);
  }
}

TEST_CASE("in the light of the first picture a saturated one is as bright in both") {
  const Texture texture;
  const Plane bright = 1.3F * texture.picture(rows, columns);
  Light light;
  light.gain[0] = 1.06;
  const Plane first = bright.min(255.0F), second = (1.06F * bright).min(255.0F);
  CHECK((first > 254).count() > 100);
  CHECK((second / 1.06F - first).abs().maxCoeff() > 10);
  const Relit relit = relight(first, second, light);
  CHECK((relit.second - relit.first).abs().maxCoeff() < 1e-3);
}

TEST_CASE("light that changes by 6 % moves nothing, and is found") {
  const Texture texture;
  const Plane first = texture.picture(rows, columns), second = texture.picture(rows, columns, 1.3, -0.6);
  FlowOptions constant;
  constant.light = LightChange::none;
  const LitFlow still = dense_flow(first, second), lit = dense_flow(first, under(lamp(), second));
  CHECK(error(dense_flow(first, under(lamp(), second), constant), 1.3F, -0.6F) > 0.2);
  CHECK(error(still, 1.3F, -0.6F) < 0.01);
  CHECK(error(lit, 1.3F, -0.6F) < 0.02);
  CHECK(apart(lit.light, lamp()) < 1);
}

TEST_CASE("nothing is smooth between sides, and a measured displacement is gone") {
  // Nothing but noise is seen: the flow is what is measured, spread by smoothness.
  const Plane blank = 1e-3F * noise(40, 60, 1, 3);
  Known known;
  known.sides = Plane::Constant(40, 60, 1);
  known.sides.leftCols(30) = -1;
  known.measured = Plane::Zero(40, 60);
  known.measured.col(10) = known.measured.col(30) = 1;
  known.displacement = Plane::Zero(40, 60);
  known.displacement.col(10) = -0.8F;
  known.displacement.col(30) = 0.5F;
  FlowOptions options;
  options.smooth_penalty = PenaltyShape::quadratic;
  options.sweeps = 100;
  const Flow parted = dense_flow(blank, blank, options, known);
  CHECK((parted.u.middleCols(10, 20) + 0.8F).abs().maxCoeff() < 0.05);
  CHECK((parted.u.middleCols(30, 30) - 0.5F).abs().maxCoeff() < 0.05);
  CHECK(parted.v.abs().maxCoeff() < 0.01);
  known.sides = {};
  const Flow joined = dense_flow(blank, blank, options, known);  // a ramp from the one to the other
  CHECK(joined.u.col(20).mean() == approx(-0.15).epsilon(0.3));
}

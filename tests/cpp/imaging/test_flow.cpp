#include <doctest/doctest.h>

#include <limits>

#include "../approx.hpp"
#include "pictures.hpp"
#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "plica/imaging/flow.hpp"
#include "plica/imaging/linearise.hpp"

using namespace plica;
using namespace plica::imaging;

namespace {

/// Mean distance of a flow from (u, v) over the pixels `margin` and more from the border.
double error(const Flow& flow, float u, float v, std::ptrdiff_t margin) {
  const std::ptrdiff_t rows = flow.u.rows() - 2 * margin, columns = flow.u.cols() - 2 * margin;
  return static_cast<double>(
      ((flow.u - u).square() + (flow.v - v).square()).sqrt().block(margin, margin, rows, columns).mean());
}

FlowOptions of_gradient() {
  FlowOptions options;
  options.smoothness = 0.1;
  options.data_scale = 0.01;
  options.smooth_scale = 0.001;
  options.data_penalty = options.smooth_penalty = PenaltyShape::charbonnier;
  options.gradient_noise = 1;
  return options;
}

}  // namespace

TEST_CASE("a translation is found, whole pixels or not, larger than the texture's waves too") {
  const Texture texture;
  const float motions[][2] = {{0.37F, -0.81F}, {-2, 3}, {7.3F, 5.6F}};
  for (const auto& m : motions) {
    const Plane first = texture.picture(96, 110), second = texture.picture(96, 110, double(m[0]), double(m[1]));
    CHECK(error(dense_flow(first, second), m[0], m[1], 12) < 0.01);
  }
}

TEST_CASE("a level begins with the motion of the coarser one in its own pixels") {
  // Three levels with one warp each, of one pixel at most: motion left in coarser pixels would stay below 3 px.
  const Texture texture;
  const Plane first = texture.picture(97, 131), second = texture.picture(97, 131, 3.8, -3.5);
  FlowOptions options;
  options.stages = options.warps = 1;
  CHECK(error(dense_flow(first, second, options), 3.8F, -3.5F, 12) < 0.3);
}

TEST_CASE("pictures that do not differ do not move") {
  const Plane first = Texture().picture(40, 50);
  const Flow flow = dense_flow(first, first);
  CHECK(flow.u.abs().maxCoeff() < 1e-4);
  CHECK(flow.v.abs().maxCoeff() < 1e-4);
  const Plane black = Plane::Zero(40, 50);
  CHECK(dense_flow(black, black).u.abs().maxCoeff() == 0);
}

TEST_CASE("swapping rows and columns swaps the flow's components") {
  const Texture texture;
  const Plane first = texture.picture(64, 80), second = texture.picture(64, 80, 1.3, -0.6);
  for (const FlowOptions& options : {FlowOptions{}, of_gradient()}) {
    const Flow flow = dense_flow(first, second, options);
    const Flow swapped = dense_flow(first.transpose(), second.transpose(), options);
    // The order of the sums, and so the round-off, differs.
    CHECK((flow.u - swapped.v.transpose()).abs().mean() < 1e-3);
    CHECK((flow.v - swapped.u.transpose()).abs().mean() < 1e-3);
  }
}

TEST_CASE("the flow has the same bits for any number of threads") {
  const Texture texture;
  const Plane first = texture.picture(150, 170) + noise(150, 170, 4, 8);
  const Plane second = texture.picture(150, 170, 2.2, 1.1) + noise(150, 170, 4, 9);
  const Flow alone = dense_flow(first, second);
  for (const int count : {2, 3, 7}) {
    set_threads(count);
    const Flow together = dense_flow(first, second);
    CHECK((alone.u == together.u).all());
    CHECK((alone.v == together.v).all());
  }
  set_threads(1);
}

TEST_CASE("what the mask leaves out does not hold the flow back") {
  // A highlight that stays where it is while the tissue under it moves.
  const Texture texture;
  Plane first = texture.picture(90, 90), second = texture.picture(90, 90, 1.5, 0.5);
  Plane used = Plane::Ones(90, 90);
  first.block(35, 35, 20, 20) = second.block(35, 35, 20, 20) = 255;
  used.block(32, 32, 26, 26) = 0;
  const Flow held = dense_flow(first, second), free = dense_flow(first, second, {}, Known{used, {}, {}, {}, {}});
  CHECK(error(held, 1.5F, 0.5F, 35) > 0.5);  // over the highlight
  CHECK(error(free, 1.5F, 0.5F, 35) < 0.1);
  const Flow all = dense_flow(first, second, {}, Known{Plane::Ones(90, 90), {}, {}, {}, {}});
  CHECK((all.u - held.u).abs().mean() < 1e-3);  // blurred ones are one to round-off
}

TEST_CASE("scaling grey levels leaves the flow where tau_D or lambda goes along") {
  const Texture texture;
  const Plane first = texture.picture(60, 60), second = texture.picture(60, 60, 0.7, 0.2);
  FlowOptions robust;
  const Flow flow = dense_flow(first, second, robust);
  robust.data_scale *= 4;
  CHECK((dense_flow(4 * first, 4 * second, robust).u == flow.u).all());

  // All is quadratic: the whole energy is 16 times as large, to the bit.
  FlowOptions quadratic;
  quadratic.data_penalty = quadratic.smooth_penalty = PenaltyShape::quadratic;
  const Flow smooth = dense_flow(first, second, quadratic);
  CHECK((smooth.u != flow.u).any());
  quadratic.smoothness *= 16;
  CHECK((dense_flow(4 * first, 4 * second, quadratic).u == smooth.u).all());
}

TEST_CASE("at scales far above all errors the Lorentzian and the Charbonnier penalty agree") {
  const Texture texture;
  const Plane first = texture.picture(60, 60), second = texture.picture(60, 60, 0.7, 0.2);
  FlowOptions options;
  options.data_scale = 1000;
  options.smooth_scale = 100;
  options.smoothness = 10;
  const Flow lorentzian = dense_flow(first, second, options);
  for (const PenaltyShape smooth : {PenaltyShape::lorentzian, PenaltyShape::charbonnier}) {
    options.data_penalty = PenaltyShape::charbonnier;
    options.smooth_penalty = smooth;
    const Flow charbonnier = dense_flow(first, second, options);
    CHECK((charbonnier.u != lorentzian.u).any());
    CHECK((charbonnier.u - lorentzian.u).abs().maxCoeff() < 1e-3);
  }
}

TEST_CASE("the gradient is exact on cubics, and continued evenly at the border") {
  Plane cubic(12, 14);
  for (std::ptrdiff_t y = 0; y < 12; ++y) {
    for (std::ptrdiff_t x = 0; x < 14; ++x) cubic(y, x) = static_cast<float>(x * x * x - 2 * x * y * y + 5 * y);
  }
  const Gradient found = gradient(cubic);
  for (std::ptrdiff_t y = 2; y < 10; ++y) {
    for (std::ptrdiff_t x = 2; x < 12; ++x) {
      CHECK(found.x(y, x) == approx(3 * x * x - 2 * y * y).epsilon(1e-4));
      CHECK(found.y(y, x) == approx(-4 * x * y + 5).epsilon(1e-4));
    }
  }
  CHECK(gradient(Plane::Constant(5, 4, 7)).x.abs().maxCoeff() < 1e-5);
  const Plane flipped = cubic.rowwise().reverse();
  CHECK((gradient(flipped).x.rowwise().reverse() == -found.x).all());
}

TEST_CASE("a normalised channel's error is a distance along the slope, and nothing where there is no slope") {
  // Slopes (3, 4) and (0, 0), moved by (0.2, 0.1): errors 3 * 0.2 + 4 * 0.1 = 1, and noise of 0.5.
  Linearisation channel{Plane::Zero(2, 3), Plane::Zero(2, 3), Plane::Constant(2, 3, 0.5F), Plane::Ones(2, 3)};
  channel.ix.row(1) = 3;
  channel.iy.row(1) = 4;
  channel.it.row(1) = 1;
  normalise(0.01F, channel);
  CHECK(channel.it(1, 1) == approx(0.2));
  CHECK(channel.ix(1, 1) == approx(0.6));
  CHECK(channel.iy(1, 1) == approx(0.8));
  normalise(1e3F, channel);
  CHECK(channel.it.abs().maxCoeff() == approx(50e-3));
  CHECK(channel.ix(0, 2) == 0);
}

TEST_CASE("with a constant gradient, light that changes moves nothing") {
  const Texture texture;
  const Plane first = texture.picture(70, 80), second = texture.picture(70, 80, 0.8, -0.4), lit = second + 20;
  FlowOptions of_brightness, constant = of_gradient();
  of_brightness.light = constant.light = LightChange::none;
  CHECK(error(dense_flow(first, lit, of_brightness), 0.8F, -0.4F, 12) > 0.3);
  CHECK(error(dense_flow(first, lit, constant), 0.8F, -0.4F, 12) < 0.01);
  const Flow dark = dense_flow(first, second, of_gradient()), bright = dense_flow(first, lit, of_gradient());
  CHECK(error(dark, 0.8F, -0.4F, 12) < 0.01);
  CHECK(error(bright, 0.8F, -0.4F, 12) < 0.01);
}

TEST_CASE("with a constant gradient, contrast does not matter where its noise goes along") {
  const Texture texture;
  const Plane first = texture.picture(60, 60), second = texture.picture(60, 60, 0.7, 0.2);
  FlowOptions options = of_gradient();
  const Flow flow = dense_flow(first, second, options);
  CHECK((dense_flow(4 * first, 4 * second, options).u != flow.u).any());
  *options.gradient_noise *= 4;
  CHECK((dense_flow(4 * first, 4 * second, options).u == flow.u).all());
}

TEST_CASE("the residual is second(x + u) - first(x), and not a number outside") {
  const Texture texture;
  const Plane first = texture.picture(50, 50), second = texture.picture(50, 50, 2.5, 0);
  const Plane u = Plane::Constant(50, 50, 2.5F), v = Plane::Zero(50, 50);
  const Plane left = residual(first, second, u, v), still = residual(first, second, 0 * u, v);
  CHECK(left.rightCols(3).isNaN().count() == 150);
  CHECK(left.block(10, 10, 30, 30).abs().maxCoeff() < 0.5);
  CHECK(still.abs().mean() > 10);
  CHECK((still - (second - first)).abs().maxCoeff() < 1e-3);
}

TEST_CASE("going there and back again misses by the sum of the flows") {
  const Plane u = Plane::Constant(30, 40, 2), v = Plane::Constant(30, 40, -1);
  const Flow there{u, v};
  const Flow exact = round_trip(there, {-u, -v}), off = round_trip(there, {-u + 3, -v + 4});
  CHECK(exact.u.isNaN().count() == 2 * 30 + 40 - 2);
  CHECK((exact.v.isNaN() == exact.u.isNaN()).all());
  CHECK(exact.u.block(1, 0, 29, 38).abs().maxCoeff() == 0);
  CHECK(exact.v.block(1, 0, 29, 38).abs().maxCoeff() == 0);
  CHECK(off.u(10, 10) == approx(3));
  CHECK(off.v(10, 10) == approx(4));
  // Where the backward flow is a ramp, linear interpolation is exact.
  Plane ramp(30, 40);
  for (std::ptrdiff_t x = 0; x < 40; ++x) ramp.col(x) = 0.1F * static_cast<float>(x);
  const Plane half = Plane::Constant(30, 40, 0.5F);
  CHECK(round_trip({half, 0 * v}, {ramp, 0 * v}).u(5, 12) == approx(0.5 + 1.25));
}

TEST_CASE("bad pictures and options are refused with what must hold") {
  const Plane good = Texture().picture(20, 30);
  Plane bad = good;
  bad(3, 4) = std::numeric_limits<float>::quiet_NaN();
  CHECK_THROWS_WITH_AS(dense_flow(good, bad),
                       "dense_flow: the second picture has nan at row 3, column 4; must be finite.", InvalidInput);
  CHECK_THROWS_WITH_AS(dense_flow(good, good.leftCols(29)),
                       "dense_flow: the second picture is 29 x 20 px; must be 30 x 20 px like the first picture.",
                       InvalidInput);
  CHECK_THROWS_WITH_AS(dense_flow(Plane::Zero(1, 1), Plane::Zero(1, 1)),
                       "dense_flow: the pictures are 1 x 1 px; must have sides of at least 8 px.", InvalidInput);
  CHECK_THROWS_AS(dense_flow(good, good, {}, Known{Plane::Ones(20, 20), {}, {}, {}, {}}), InvalidInput);
  CHECK_THROWS_AS(dense_flow(1e30F * good, 1.1e30F * good), SolveFailed);
  FlowOptions options;
  options.smoothness = 0;
  CHECK_THROWS_WITH_AS(dense_flow(good, good, options), "FlowOptions: smoothness = 0; must be in [1e-06, 1e+06].",
                       InvalidInput);
  options = {};
  options.relaxation = 2;
  CHECK_THROWS_WITH_AS(options.validate(), "FlowOptions: relaxation = 2; must be in (0, 2).", InvalidInput);
  options = {};
  options.gradient_noise = 0;
  CHECK_THROWS_WITH_AS(options.validate(),
                       "FlowOptions: gradient_noise = 0 grey levels per px^2; must be in [0.001, 1000].",
                       InvalidInput);
}

#include <cmath>
#include <limits>

#include "../borders.hpp"
#include "plica/imaging/flow.hpp"
#include "plica/imaging/linearise.hpp"
#include "plica/imaging/median.hpp"
#include "plica/imaging/resample.hpp"

using namespace plica;
using namespace plica::imaging;
using borders::Empty;
using borders::Longer;
using borders::numbers;
using borders::sizes;

namespace {

Plane picture() { return 128 + 100 * Plane::Random(16, 16); }
Plane still() { return Plane::Zero(16, 16); }

}  // namespace

TEST_CASE("filters refuse pictures without pixels and sizes that no picture has") {
  const Plane image = picture();
  for (const Plane& empty : {Plane(), Plane(0, 5), Plane(5, 0)}) {
    Plane result;
    CHECK_THROWS_AS(blur(empty, 1.0), InvalidInput);
    CHECK_THROWS_AS(resize(empty, 4, 4), InvalidInput);
    CHECK_THROWS_AS(pyramid(empty, 2, 2.0), InvalidInput);
    CHECK_THROWS_AS(median_5x5(empty, result), InvalidInput);
    CHECK_THROWS_AS(Spline{empty}, InvalidInput);
    CHECK_THROWS_AS(gradient(empty), InvalidInput);
  }
  double sigma = 1;
  numbers("sigma", sigma,
          {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()},
          [&] { blur(image, sigma); });
  CHECK((blur(image, 0.0) == image).all());  // the limit of narrow filters
  std::ptrdiff_t rows = 4, columns = 4;
  numbers<std::ptrdiff_t>("rows", rows, {0, -1}, [&] { resize(image, rows, columns); });
  numbers<std::ptrdiff_t>("columns", columns, {0, -1}, [&] { resize(image, rows, columns); });
  int levels = 2;
  numbers("levels", levels, {0, -1}, [&] { pyramid(image, levels, 2.0); });
  double spacing = 2;
  numbers("spacing", spacing, {1.0, 0.0, -2.0}, [&] { pyramid(image, 2, spacing); });
  Light light;
  numbers<std::ptrdiff_t>("rows of gains", rows, {0, -1}, [&] { light.gains(rows, columns); });
}

TEST_CASE("what compares pictures refuses unlike sizes") {
  Plane first = picture(), second = picture(), u = still(), v = still();
  const auto left = [&] { residual(first, second, u, v); };
  for (Plane* plane : {&first, &second, &u, &v}) sizes("residual", *plane, left);

  Flow forward{still(), still()}, backward = forward;
  const auto round = [&] { round_trip(forward, backward); };
  for (Plane* plane : {&forward.u, &forward.v, &backward.u, &backward.v}) sizes("round_trip", *plane, round);

  Plane used = Plane::Ones(16, 16);
  const Spline spline(second);
  const auto fit = [&] { fit_light(first, second, spline, used, u, v); };
  for (Plane* plane : {&first, &second, &u, &v}) sizes("fit_light", *plane, fit);
  const auto lit = [&] { relight(first, second, {}); };
  for (Plane* plane : {&first, &second}) sizes("relight", *plane, lit);
}

TEST_CASE("a flow refuses pictures of unlike sizes and a measured motion along no direction") {
  Plane first = picture(), second = first;
  Known known;
  known.measured = Plane::Ones(16, 16);
  known.displacement = still();
  FlowOptions options;
  options.warps = 1;
  const auto flow = [&] { dense_flow(first, second, options, known); };
  sizes("dense_flow first", first, flow);
  sizes("dense_flow second", second, flow);
  sizes("dense_flow known.displacement", known.displacement, flow);
  sizes("dense_flow known.measured", known.measured, flow, Longer::refused, Empty::none);
  known.used = known.sides = Plane::Ones(16, 16);
  sizes("dense_flow known.used", known.used, flow, Longer::refused, Empty::none);
  sizes("dense_flow known.sides", known.sides, flow, Longer::refused, Empty::none);
  for (const std::array<double, 2>& across : {std::array<double, 2>{0, 0}, {2, 0}, {std::nan(""), 1}}) {
    known.across = across;
    CHECK_THROWS_WITH_AS(flow(), doctest::Contains("across"), InvalidInput);
  }
}

TEST_CASE("the equations of a warp refuse planes of another size") {
  Plane first = picture(), u = still(), v = still(), used = Plane::Ones(16, 16), sides = used;
  const Spline second(picture());
  PlaneRow warped(16), inside(16);
  std::ptrdiff_t y = 3;
  const auto row = [&] { second.warp_row(y, u, v, warped, inside); };
  numbers<std::ptrdiff_t>("Spline::warp_row y", y, {-1, 16, 1 << 30}, row);
  sizes("Spline::warp_row u", u, row);
  sizes("Spline::warp_row v", v, row);
  for (const std::ptrdiff_t size : {0, 15, 17}) {
    PlaneRow other(size);
    CHECK_THROWS_AS(second.warp_row(y, u, v, other, inside), InvalidInput);
    CHECK_THROWS_AS(second.warp_row(y, u, v, warped, other), InvalidInput);
  }
  Linearisation channel;
  const auto line = [&] { linearise(first, second, used, u, v, channel); };
  sizes("linearise first", first, line);
  sizes("linearise used", used, line, Longer::refused, Empty::none);
  sizes("linearise u", u, line);
  sizes("linearise v", v, line);
  line();
  FlowSystem system(16, 16);
  std::vector<Linearisation> channels{channel};
  const auto assemble = [&] { system.assemble(channels, u, v, {1, 0, 1}, {1, 0, 1}, 1, sides); };
  for (Plane* plane : {&channels[0].ix, &channels[0].iy, &channels[0].it, &channels[0].trust, &u, &v})
    sizes("FlowSystem::assemble planes", *plane, assemble);
  sizes("FlowSystem::assemble sides", sides, assemble, Longer::refused, Empty::none);
  std::ptrdiff_t rows = 16, columns = 16;
  numbers<std::ptrdiff_t>("FlowSystem::FlowSystem rows", rows, {0, -1}, [&] { FlowSystem(rows, 16); });
  numbers<std::ptrdiff_t>("FlowSystem::FlowSystem columns", columns, {0, -1}, [&] { FlowSystem(16, columns); });
}

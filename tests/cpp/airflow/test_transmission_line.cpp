// Sound in tubes, against closed forms and against waves that are scattered where the area changes.
#include <doctest/doctest.h>

#include <cmath>
#include <complex>

#include "../approx.hpp"
#include "plica/airflow/transmission_line.hpp"
#include "plica/core/constants.hpp"
#include "plica/core/error.hpp"

using namespace plica;

namespace {

constexpr Gas gas{1.2, 350.0, 1.8e-5};
constexpr double area = 3e-4;

Tube uniform(double length, decltype(Tube::end) end = PressureSupply{}) {
  Tube tube{{length}, {area}, end, {}, 0.0};
  return tube;
}

/// A pulse of flow that has no sound above some 2 kHz.
double pulse(double t) { return 1e-4 * std::exp(-0.5 * std::pow((t - 1.2e-3) / 2e-4, 2)); }

/// Pa at the glottis after each step, of a line that begins at rest, driven by a flow.
template <class Flow>
std::vector<double> response(const Tube& tube, Flow flow, int count, double step, double longest = 1e-3,
                             double substep = 1e-6) {
  const TransmissionLine line(tube, gas, "tube", longest);
  LineStep walk(line, step, substep);
  LineWork work;
  Vector state = line.steady(0.0, 0.0);
  std::vector<double> pressure;
  for (int i = 0; i < count; ++i) {
    walk.begin(state, flow(i * step), 0.0, 0.0);
    state = walk.end(flow((i + 1) * step), &work);
    pressure.push_back(state[0]);
  }
  return pressure;
}

/// Hz, where the spectrum of a ringing signal is largest between two frequencies.
double peak(const std::vector<double>& signal, double step, double low, double high) {
  const auto size = [&](double f) {
    std::complex<double> sum = 0;
    for (std::size_t i = 0; i < signal.size(); ++i) {
      const double at = (static_cast<double>(i) + 0.5) / static_cast<double>(signal.size());
      sum += signal[i] * std::pow(std::sin(pi * at), 2) *
             std::polar(1.0, -2 * pi * f * step * static_cast<double>(i));
    }
    return std::abs(sum);
  };
  for (int i = 0; i < 60; ++i) {
    const double third = (high - low) / 3;
    (size(low + third) < size(high - third) ? low : high) +=
        size(low + third) < size(high - third) ? third : -third;
  }
  return 0.5 * (low + high);
}

}  // namespace

TEST_CASE("what enters a tube without losses is stored or radiated, to round-off") {
  for (const bool yields : {false, true})
    for (const int end : {0, 1, 2, 3}) {
      Tube tube{{0.02, 0.05, 0.1}, {1e-4, 4e-4, 2e-4}, Radiation{}, {}, 0.0};
      if (end == 1) tube.end = PressureSupply{1.0, 0.0};
      if (end == 2) tube.end = FlowSupply{};
      if (end == 3) tube.end = FlowSupply{2e-5};
      if (yields) tube.wall = YieldingWall{21.0, 0.0, 8.45e5};
      const TransmissionLine line(tube, gas, "tube");
      LineStep step(line, 5e-5);
      const auto source = [&](int i) { return end >= 2 ? -2e-4 * std::sin(0.3 * i) : 300 * std::cos(0.2 * i); };
      const auto flow = [](int i) { return 2e-4 * std::sin(0.11 * i) + 1e-4; };
      Vector state = line.steady(flow(0), source(0));
      LineWork work;
      double moved = 0;
      for (int i = 0; i < 400; ++i) {
        const LineWork last = work;
        step.begin(state, flow(i), source(i), source(i + 1));
        state = step.end(flow(i + 1), &work);
        CHECK(state[0] == approx(step.pressure() + step.impedance() * flow(i + 1)).epsilon(1e-9));
        moved += std::abs(work.port - last.port) + std::abs(work.source - last.source);
      }
      CHECK(moved > 1e-4);
      CHECK(std::abs(work.lost) < 1e-12 * moved);
      CHECK((work.radiated > 0) == (end == 0));
      CHECK((work.source != 0) == (end != 0));
    }
}

TEST_CASE("what a step does is linear in the flow at its end") {
  Tube tube{{0.02, 0.05}, {1e-4, 4e-4}, Radiation{}, YieldingWall{}, 1000.0};
  const TransmissionLine line(tube, gas, "tube");
  LineStep whole(line, 5e-5), half(line, 2.5e-5);  // of as many substeps, so that both are the same walk
  const Vector before = line.steady(1e-4, 0);
  whole.begin(before, 1e-4, 0, 0);
  LineWork once, twice;
  const Vector there = whole.end(3e-4, &once);
  half.begin(before, 1e-4, 0, 0);
  const Vector midway = half.end(2e-4, &twice);
  half.begin(midway, 2e-4, 0, 0);
  CHECK((half.end(3e-4, &twice) - there).cwiseAbs().maxCoeff() < 1e-12 * there.cwiseAbs().maxCoeff());
  CHECK(once.port == approx(twice.port).epsilon(1e-12));
  CHECK(once.lost == approx(twice.lost).epsilon(1e-9));
}

TEST_CASE("friction in walls takes the energy of their ringing") {
  // One closed element whose wall rings: its energy falls as exp(-b t / m), but for what stays in the stiffness of
  // the wall that holds the air where it comes to rest.
  const double resistance = 300, t = 0.1;
  Tube tube = uniform(4e-3, FlowSupply{});
  tube.wall = YieldingWall{21.0, resistance, 8.45e5};
  const TransmissionLine line(tube, gas, "tube", 4e-3);
  LineStep walk(line, 1e-5);
  Vector state = line.steady(0, 0);
  state[0] = state[1] = 100;
  const double before = line.energy(state);
  LineWork work;
  for (int i = 0; i < 10000; ++i) {
    walk.begin(state, 0, 0, 0);
    state = walk.end(0, &work);
  }
  const double air = 2 * std::sqrt(pi / area) * gas.density * gas.sound_speed * gas.sound_speed;  // Pa/m
  const double rings = before * air / (air + 8.45e5);
  CHECK(work.lost == approx(rings * (1 - std::exp(-resistance * t / 21.0))).epsilon(5e-3));
}

TEST_CASE("a uniform tube rings at odd quarters of c / L, with an error of second order") {
  const double L = 0.175;
  for (const int k : {1, 2, 3}) {
    const double exact = (2 * k - 1) * gas.sound_speed / (4 * L);
    double error[2];
    for (const int finer : {0, 1}) {
      const double longest = finer ? 1.75e-3 : 3.5e-3, step = finer ? 6.25e-6 : 1.25e-5;
      const auto ring = response(uniform(L), pulse, finer ? 8000 : 4000, step, longest, step);
      error[finer] = peak(ring, step, 0.97 * exact, 1.03 * exact) / exact - 1;
    }
    CHECK(std::abs(error[1]) < 1.5e-3);
    CHECK(error[0] / error[1] == approx(4).epsilon(0.1));
    // The rule's own, atan(x) / x of x = pi f h, and that of the elements, sin(x) / x of x = pi f l / c.
    const double x = pi * exact * 6.25e-6, y = pi * exact * 1.75e-3 / gas.sound_speed;
    CHECK(std::abs(error[1] - (std::atan(x) / x * std::sin(y) / y - 1)) < 1e-5);
  }
}

TEST_CASE("two tubes ring where tan(k L1) tan(k L2) is the ratio of their areas") {
  const double L1 = 0.09, L2 = 0.08, A1 = 1e-4, A2 = 7e-4;
  const Tube tube{{L1, L2}, {A1, A2}, PressureSupply{}, {}, 0.0};
  const auto ring = response(tube, pulse, 6000, 1e-5);
  const auto off = [&](double f) {
    const double k = 2 * pi * f / gas.sound_speed;
    return std::sin(k * L1) * std::sin(k * L2) * A1 - std::cos(k * L1) * std::cos(k * L2) * A2;
  };
  int found = 0;
  for (double f = 100; f < 3000; f += 1) {
    if (off(f) * off(f + 1) > 0) continue;
    const double exact = f + off(f) / (off(f) - off(f + 1));
    CHECK(peak(ring, 1e-5, 0.97 * exact, 1.03 * exact) == approx(exact).epsilon(1e-3));
    ++found;
  }
  CHECK(found == 3);
}

TEST_CASE("nothing comes back from a matched end") {
  const auto pressure = response(uniform(0.2, PressureSupply{0.0}), pulse, 4000, 1e-6);
  double most = 0;
  for (std::size_t i = 0; i < pressure.size(); ++i)
    most = std::max(most, std::abs(pressure[i] - gas.density * gas.sound_speed / area *
                                                     pulse(static_cast<double>(i + 1) * 1e-6)));
  CHECK(most < 2e-3 * gas.density * gas.sound_speed / area * 1e-4);
}

TEST_CASE("an end gives back its share of a wave") {
  const double L = 0.35, r = 0.4, wave = gas.density * gas.sound_speed / area * 1e-4;  // Pa, of the pulse
  const auto pressure = response(uniform(L, PressureSupply{r}), pulse, 5000, 1e-6);
  const auto back = static_cast<std::size_t>(std::lround((1.2e-3 + 2 * L / gas.sound_speed) / 1e-6));
  CHECK(pressure[back - 1] == approx(-2 * r * wave).epsilon(0.02));  // the glottis is closed: it doubles there
}

TEST_CASE("a volume at the end empties through its resistance") {
  const double L = 4e-3, r = 0.3, V = 1e-4;
  const TransmissionLine line(uniform(L, PressureSupply{r, V}), gas, "tube");
  const double resistance = gas.density * gas.sound_speed / area * (1 - r) / (1 + r);
  const double tau = resistance * (V + L * area) / (gas.density * gas.sound_speed * gas.sound_speed);
  LineStep walk(line, 1e-5, 1e-6);
  Vector state = line.steady(0, 0);
  state[0] = state[1] = 100;
  for (int i = 0; i < 100; ++i) {
    walk.begin(state, 0, 0, 0);
    state = walk.end(0);
  }
  CHECK(state[1] == approx(100 * std::exp(-1e-3 / tau)).epsilon(0.01));
}

TEST_CASE("friction is that of a boundary layer") {
  const double f = 700, L = 0.16;
  Tube tube = uniform(L);
  tube.friction_frequency = f;
  const TransmissionLine line(tube, gas, "tube");
  const double thickness = std::sqrt(gas.viscosity / (pi * f * gas.density));  // m, of Stokes's layer
  const double shear = gas.viscosity / thickness * 2 * std::sqrt(pi * area) / (area * area);
  CHECK(line.steady_resistance() == approx(shear * L).epsilon(1e-12));
}

TEST_CASE("a volume behind a neck is a Helmholtz resonator") {
  // Its neck is held at the glottis by its own flow: the far end is closed by the volume.
  const double L = 0.01, V = 2e-5;
  const Tube tube{{L}, {1e-5}, FlowSupply{V}, {}, 0.0};
  const TransmissionLine line(tube, gas, "tube", 1e-3);
  // Open at the glottis: the flow that keeps the pressure there at 0, from the affine relation of a step.
  LineStep step(line, 1e-5);
  Vector state = line.steady(0.0, 0.0);
  state[10] = 100;
  LineWork work;
  double flow = 0;
  std::vector<double> ring;
  for (int i = 0; i < 8000; ++i) {
    step.begin(state, flow, 0, 0);
    flow = -step.pressure() / step.impedance() * 0.999;
    state = step.end(flow, &work);
    ring.push_back(state[10]);
  }
  const double exact = gas.sound_speed / (2 * pi) * std::sqrt(1e-5 / (V * L));
  CHECK(peak(ring, 1e-5, 0.9 * exact, 1.1 * exact) == approx(exact).epsilon(0.01));
}

TEST_CASE("the response at a frequency is that of the steps, and a closed form's") {
  // Rigid, without friction: Z = i rho c / A tan(k L) of an end at a held pressure, and 1 / cos(k L) of the flow.
  const double L = 0.17;
  const TransmissionLine fine(uniform(L), gas, "tube", 1e-4);
  for (const double f : {100.0, 700.0, 2300.0}) {
    const double k = 2 * pi * f / gas.sound_speed;
    const auto [impedance, transfer] = fine.response({0.0, 2 * pi * f});
    CHECK(impedance.imag() == approx(gas.density * gas.sound_speed / area * std::tan(k * L)).epsilon(1e-4));
    CHECK(transfer.real() == approx(1 / std::cos(k * L)).epsilon(1e-4));
    CHECK(std::abs(impedance.real()) < 1e-9 * std::abs(impedance));
  }
  // With walls, friction and every end: steps of a flow exp(s t) in small substeps, once the beginning has died.
  for (const int end : {0, 1, 2, 3}) {
    Tube tube{{0.02, 0.05, 0.1}, {1e-4, 4e-4, 2e-4}, Radiation{}, YieldingWall{}, 1000.0};
    if (end == 1) tube.end = PressureSupply{1.0, 0.0};
    if (end == 2) tube.end = PressureSupply{0.3, 1e-5};
    if (end == 3) tube.end = FlowSupply{2e-5};
    const TransmissionLine line(tube, gas, "tube");
    const double rate = 2000, step = 2e-6;
    LineStep walk(line, step, 2e-7);
    Vector state = line.steady(0.0, 0.0);
    double flow = 0, then = 0;
    for (int i = 0; i < 10000; ++i, flow = then) {
      then = std::exp(rate * step * (i + 1) - 40);
      walk.begin(state, flow, 0, 0);
      state = walk.end(then);
    }
    const auto [impedance, transfer] = line.response({rate, 0.0});
    CHECK(state[0] / flow == approx(impedance.real()).epsilon(1e-4));
    CHECK(line.end_flow(state, 0) / flow == approx(transfer.real()).epsilon(1e-4));
  }
}

TEST_CASE("pressure here by flow there is pressure there by flow here") {
  Tube tube{{0.03, 0.06, 0.05}, {1e-4, 5e-4, 2e-4}, FlowSupply{}, YieldingWall{}, 1000.0};
  const TransmissionLine line(tube, gas, "tube");
  LineStep step(line, 2e-5);
  LineWork work;
  Vector here = line.steady(0, 0), there = here;
  const std::ptrdiff_t far = 35;  // 0.14 m in elements of 3.75, 4 and 3.85 mm
  REQUIRE(line.size() == 4 * (far + 2) - 1);
  for (int i = 0; i < 300; ++i) {
    const double now = pulse(i * 2e-5), then = pulse((i + 1) * 2e-5);
    step.begin(here, now, 0, 0);
    here = step.end(then, &work);
    step.begin(there, 0, now, then);
    there = step.end(0, &work);
    CHECK(there[0] == approx(here[far + 1]).epsilon(1e-9));
  }
}

TEST_CASE("waves that are scattered where the area changes are the same") {
  // Kelly and Lochbaum: sections that sound passes in one step, no dispersion.
  const std::vector<double> areas{1e-4, 1e-4, 3e-4, 6e-4, 2e-4, 2e-4, 5e-4, 4e-4};
  const double T = 2e-5, length = gas.sound_speed * T;
  Tube tube{std::vector<double>(areas.size(), length), areas, PressureSupply{}, {}, 0.0};
  const int count = 800;
  const auto found = response(tube, pulse, count, T, 5e-4, 5e-7);
  const std::size_t n = areas.size();
  std::vector<double> up(n, 0.0), down(n, 0.0);  // as they arrive at a section's far and near end
  double most = 0, off = 0;
  for (int i = 0; i < count; ++i) {
    std::vector<double> next_up(n), next_down(n);
    next_up[0] = down[0] + gas.density * gas.sound_speed / areas[0] * pulse((i + 1) * T);
    const double pressure = next_up[0] + down[0];
    for (std::size_t k = 0; k + 1 < n; ++k) {
      const double r = (areas[k] - areas[k + 1]) / (areas[k] + areas[k + 1]);
      next_up[k + 1] = (1 + r) * up[k] - r * down[k + 1];
      next_down[k] = r * up[k] + (1 - r) * down[k + 1];
    }
    next_down[n - 1] = -up[n - 1];
    up = next_up;
    down = next_down;
    most = std::max(most, std::abs(pressure));
    off = std::max(off, std::abs(pressure - found[static_cast<std::size_t>(i)]));
  }
  CHECK(off < 0.01 * most);
}

TEST_CASE("an open end radiates as a piston in a wall does") {
  const double a = std::sqrt(area / pi);
  for (const double ka : {0.1, 0.3}) {
    const double f = ka * gas.sound_speed / (2 * pi * a), step = 1 / f / 200;
    const TransmissionLine line(uniform(1e-3, Radiation{}), gas, "tube");
    LineStep walk(line, step);
    Vector state = line.steady(0, 0);
    LineWork work, before;
    double mean_square = 0;
    for (int i = 0; i < 4000; ++i) {
      if (i == 3000) before = work;
      walk.begin(state, 1e-4 * std::sin(2 * pi * i / 200), 0, 0);
      state = walk.end(1e-4 * std::sin(2 * pi * (i + 1) / 200), &work);
      if (i >= 3000) mean_square += std::pow(line.end_flow(state, 0), 2) / 1000;
    }
    const double power = (work.radiated - before.radiated) / (1000 * step);
    const double piston = 1 - std::cyl_bessel_j(1, 2 * ka) / ka;
    CHECK(power == approx(mean_square * gas.density * gas.sound_speed / area * piston).epsilon(0.05));
  }
}

TEST_CASE("a wall that yields rings with the air it encloses") {
  Tube tube = uniform(4e-3, FlowSupply{});
  tube.wall = YieldingWall{21.0, 0.0, 8.45e5};
  const TransmissionLine line(tube, gas, "tube", 4e-3);
  LineStep walk(line, 1e-5);
  Vector state = line.steady(0, 0);
  state[0] = state[1] = 100;
  LineWork work;
  std::vector<double> ring;
  for (int i = 0; i < 10000; ++i) {
    walk.begin(state, 0, 0, 0);
    state = walk.end(0, &work);
    ring.push_back(state[0]);
  }
  const double spring = 2 * std::sqrt(pi / area) * gas.density * gas.sound_speed * gas.sound_speed;
  const double exact = std::sqrt((8.45e5 + spring) / 21.0) / (2 * pi);
  CHECK(peak(ring, 1e-5, 0.9 * exact, 1.1 * exact) == approx(exact).epsilon(1e-3));
}

TEST_CASE("a steady flow stays as it is, and pays its resistance") {
  for (const int end : {0, 1, 2}) {
    Tube tube{{0.1, 0.07}, {2e-4, 4e-4}, Radiation{}, YieldingWall{}, 800.0};
    if (end == 1) tube.end = PressureSupply{};
    if (end == 2) tube.end = PressureSupply{0.2};
    const double source = end == 0 ? 0.0 : 700.0, flow = end == 0 ? 3e-4 : -3e-4;
    const TransmissionLine line(tube, gas, "tube");
    const Vector steady = line.steady(flow, source);
    CHECK(steady[0] == approx(source + line.steady_resistance() * flow));
    CHECK(line.end_flow(steady, source) == approx(flow));
    LineStep step(line, 5e-5);
    LineWork work;
    Vector state = steady;
    for (int i = 0; i < 100; ++i) {
      step.begin(state, flow, source, source);
      state = step.end(flow, &work);
    }
    CHECK(work.lost == approx(5e-3 * line.steady_resistance() * flow * flow).epsilon(1e-9));
    CHECK(work.port == approx(5e-3 * steady[0] * flow).epsilon(1e-9));
    CHECK(work.source == approx(end == 0 ? 0.0 : -5e-3 * source * flow).epsilon(1e-9));
    CHECK(std::abs(work.radiated) < 1e-9 * work.lost);
    CHECK((state - steady).cwiseAbs().maxCoeff() < 1e-9 * steady.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("a step of no duration changes nothing") {
  const TransmissionLine line(uniform(0.1), gas, "tube");
  LineStep step(line, 0.0);
  const Vector state = line.steady(1e-4, 500);
  step.begin(state, 1e-4, 500, 500);
  LineWork work;
  CHECK(step.impedance() == 0);
  CHECK(step.pressure() == state[0]);
  CHECK(step.end(2e-4, &work) == state);
}

TEST_CASE("tubes that are none are refused by name") {
  const auto text = [](const Tube& tube) {
    try {
      const TransmissionLine line(tube, gas, "Tract");
      return std::string();
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
  };
  const auto contains = [&](const Tube& tube, const char* what) {
    const std::string said = text(tube);
    INFO(said);
    CHECK(said.find(what) != std::string::npos);
    CHECK(said.rfind("Tract: ", 0) == 0);
  };
  contains({{}, {}}, "parts of the tube");
  contains({{0.1, 0.1}, {1e-4}}, "number of areas");
  contains({{0.0}, {1e-4}}, "length of part 0");
  contains({{175.0}, {1e-4}}, "length of part 0");
  contains({{0.1}, {0.0}}, "area of part 0");
  contains({{0.1, 0.1}, {1e-4, NAN}}, "area of part 1");
  contains({{0.1}, {1e-4}, PressureSupply{1.1}}, "reflection");
  contains({{0.1}, {1e-4}, PressureSupply{1, -1}}, "volume");
  contains({{0.1}, {1e-4}, PressureSupply{1, 1e-3}}, "a reflection of 1");
  contains({{0.1}, {1e-4}, FlowSupply{-1}}, "volume");
  contains({{0.1}, {1e-4}, Radiation{}, YieldingWall{0}}, "mass of the wall");
  contains({{0.1}, {1e-4}, Radiation{}, YieldingWall{1, -1}}, "resistance of the wall");
  contains({{0.1}, {1e-4}, Radiation{}, YieldingWall{1, 1, 0}}, "stiffness of the wall");
  contains({{0.1}, {1e-4}, Radiation{}, {}, -1}, "friction_frequency");
  const TransmissionLine line(uniform(0.1), gas, "tube");
  CHECK_THROWS_AS(LineStep(line, -1e-6), InvalidInput);
  CHECK_THROWS_AS(LineStep(line, 1e-6, 0.0), InvalidInput);
  LineStep step(line, 1e-5);
  CHECK_THROWS_AS(step.begin(Vector::Zero(3), 0, 0, 0), InvalidInput);
  CHECK_THROWS_AS(line.energy(Vector::Zero(3)), InvalidInput);
  CHECK_THROWS_AS(line.end_flow(Vector::Zero(3), 0), InvalidInput);
  CHECK_THROWS_AS(line.response(0.0), InvalidInput);
}

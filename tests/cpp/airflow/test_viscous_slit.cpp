#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <random>

#include "../approx.hpp"
#include "plica/airflow/flow_model.hpp"

using namespace plica;

namespace {

constexpr double length = 14e-3;  // m
const Air air{800, 1.2};

/// Sections over 6 mm.
struct Slit {
  Vector height, lengths;
  explicit Slit(int sections)
      : height(Vector::LinSpaced(sections, 0, 6e-3)), lengths(Vector::Constant(sections, length)) {}
  FlowState flow(const ViscousSlit& model, const Vector& areas, const Air& driven_by = air) const {
    return viscous_slit_flow(model, driven_by, {height, lengths}, areas);
  }
};

Vector list(std::initializer_list<double> values) {
  Vector v(static_cast<std::ptrdiff_t>(values.size()));
  std::copy(values.begin(), values.end(), v.begin());
  return v;
}

/// A smooth curve of areas with several minima, some of it closed where `closing` is large; m^2.
Vector random_areas(std::mt19937& random, const Vector& height, double closing) {
  std::uniform_real_distribution<double> unit(0, 1);
  Vector areas = Vector::Constant(height.size(), 8e-6 * (1 - closing));
  for (int wave = 1; wave < 7; ++wave) {
    const double size = 6e-6 * (unit(random) - 0.5) * 2 / wave, phase = 6.3 * unit(random);
    areas.array() += size * (wave * 1000 * height.array() + phase).cos();
  }
  return areas;
}

}  // namespace

TEST_CASE("without viscosity and with separation at the least area the flow is Bernoulli's") {
  const Slit slit(9);
  const Vector areas = 1e-6 * list({90, 60, 40, 20, 9, 5, 7, 30, 80});
  const FlowState thesis = bernoulli_flow(air, 0, areas, false);
  const FlowState flow = slit.flow({1 + 1e-12, 0, 3e-4}, areas);
  CHECK(thesis.separation == 5);
  CHECK(flow.separation == 6);  // the interval in which the jet leaves the wall begins at the least section
  CHECK(flow.flow == approx(thesis.flow).epsilon(1e-11));
  for (int i = 0; i < 9; ++i) CHECK(std::abs(flow.pressure[i] - thesis.pressure[i]) < 1e-8);
  CHECK(flow.viscous_power == 0);
  CHECK(thesis.jet_power == approx(0.5 * air.density * std::pow(thesis.flow, 3) / 25e-12).epsilon(1e-12));
}

TEST_CASE("a section just below the ratio is of the stream, one just above it of the jet") {
  const Slit slit(4);
  for (const double beside : {1e-6, -1e-6}) {
    const double ratio = 1.2, last = (ratio + beside) * 5e-6;
    const FlowState flow = slit.flow({ratio, 0, 3e-4}, 1e-6 * list({20, 5, 5.5, 1e6 * last}));
    const double exit = std::min(last, ratio * 5e-6);
    CHECK(flow.flow == approx(exit * std::sqrt(2 * air.subglottal_pressure / air.density)).epsilon(1e-12));
  }
  const FlowState detached = slit.flow({1.2, 0, 3e-4}, 1e-6 * list({20, 5, 6.06, 6.3}));
  CHECK(detached.flow == approx(6e-6 * std::sqrt(2 * air.subglottal_pressure / air.density)).epsilon(1e-12));
  CHECK(detached.pressure[2] == 0);
  CHECK(detached.pressure[3] == 0);
}

TEST_CASE("the jet leaves between sections where the area is the ratio times the least one") {
  const Slit slit(9);
  const Vector areas = 1e-6 * list({90, 60, 40, 20, 9, 5, 5.5, 30, 80});
  const FlowState flow = slit.flow({1.2, 0, 3e-4}, areas);
  const double jet = 1.2 * 5e-6, head = air.subglottal_pressure * jet * jet;
  CHECK(flow.flow == approx(jet * std::sqrt(2 * air.subglottal_pressure / air.density)).epsilon(1e-13));
  CHECK(flow.separation == 7);
  for (int i = 0; i < 7; ++i)
    CHECK(flow.pressure[i] == approx(air.subglottal_pressure - head / (areas[i] * areas[i])));
  CHECK(flow.pressure[5] == approx(-0.44 * air.subglottal_pressure));  // suction in the throat
  CHECK(flow.pressure.tail(2).isZero(0));
}

TEST_CASE("where the glottis does not widen enough the jet leaves at the exit") {
  const Slit slit(6);
  const Vector areas = 1e-6 * list({90, 40, 20, 10, 10.5, 11});
  const FlowState flow = slit.flow({1.2, 0, 3e-4}, areas);
  CHECK(flow.separation == 5);
  CHECK(flow.flow == approx(11e-6 * std::sqrt(2 * air.subglottal_pressure / air.density)).epsilon(1e-13));
  CHECK(flow.pressure[5] == 0);
  CHECK(flow.pressure[3] < 0);
}

TEST_CASE("a second narrower place past a hump takes up the jet again") {
  const Slit slit(8);
  const FlowState flow = slit.flow({1.2, 0, 3e-4}, 1e-6 * list({90, 10, 30, 30, 5, 30, 60, 90}));
  const double jet = 6e-6, head = air.subglottal_pressure * jet * jet;
  CHECK(flow.flow == approx(jet * std::sqrt(2 * air.subglottal_pressure / air.density)).epsilon(1e-13));
  // In the hump the stream keeps 1.2 times the first throat's area.
  for (const int i : {2, 3}) CHECK(flow.pressure[i] == approx(air.subglottal_pressure - head / (12e-6 * 12e-6)));
  CHECK(flow.separation == 5);
}

TEST_CASE("the loss of a converging slit is the integral of 12 mu W^2 / a^3, for any number of sections") {
  const double from = 20e-6, to = 2e-6, mu = 1.8e-5;
  // a linear: integral of 1 / a^3 = L (a_0 + a_1) / (2 a_0^2 a_1^2)
  const double exact = 12 * mu * length * length * 6e-3 * (from + to) / (2 * from * from * to * to);
  for (const int sections : {2, 5, 40}) {
    const FlowState flow = Slit(sections).flow({1.2, mu, 3e-4}, Vector::LinSpaced(sections, from, to));
    CHECK(flow.viscous_power == approx(exact * flow.flow * flow.flow).epsilon(1e-12));
  }
}

TEST_CASE("in a widening slit friction falls to zero where the jet leaves, for any number of sections") {
  const double from = 2e-6, to = 12e-6, mu = 1.8e-5, r = 1.2;
  // a from m to r m: integral of (r - a / m) / (r - 1) / a^3 da by the midpoint rule
  double integral = 0;
  const int n = 20000;
  for (int k = 0; k < n; ++k) {
    const double a = from * (1 + (r - 1) * (k + 0.5) / n);
    integral += (r - a / from) / (r - 1) / (a * a * a) * from * (r - 1) / n;
  }
  const double exact = 12 * mu * length * length * integral * 6e-3 / (to - from);
  for (const int sections : {2, 5, 40, 401}) {
    const FlowState flow = Slit(sections).flow({r, mu, 3e-4}, Vector::LinSpaced(sections, from, to));
    CHECK(flow.viscous_power == approx(exact * flow.flow * flow.flow).epsilon(1e-8));
  }
}

TEST_CASE("the power supplied leaves with the jet or is lost to friction, and the subglottal pressure is spent") {
  std::mt19937 random(3);
  const Slit slit(30);
  for (int trial = 0; trial < 300; ++trial) {
    const FlowState flow = slit.flow({}, random_areas(random, slit.height, trial % 3 / 2.0));
    CHECK(flow.supplied_power == approx(flow.jet_power + flow.viscous_power).epsilon(1e-12));
    CHECK(flow.supplied_power == approx(air.subglottal_pressure * flow.flow).epsilon(1e-14));
    CHECK(flow.pressure.maxCoeff() <= air.subglottal_pressure);
    CHECK(flow.pressure.minCoeff() >=
          -0.44 * air.subglottal_pressure * (1 + 1e-12));  // 1 - 1.2^2 of the jet's head
    for (int i = flow.separation; i < 30; ++i) CHECK(std::abs(flow.pressure[i]) < 1e-9);
  }
}

TEST_CASE("more pressure drives more flow, wider sections let more through") {
  std::mt19937 random(5);
  const Slit slit(30);
  for (int trial = 0; trial < 100; ++trial) {
    const Vector areas = random_areas(random, slit.height, trial % 4 / 3.0);
    double last = 0;
    for (const double pressure : {1.0, 200.0, 800.0, 4000.0}) {
      const double flow = slit.flow({}, areas, {pressure, 1.2}).flow;
      CHECK(flow > last);
      last = flow;
    }
    CHECK(slit.flow({}, 1.1 * areas.cwiseMax(0)).flow >= slit.flow({}, areas.cwiseMax(0)).flow);
  }
}

TEST_CASE("closed folds hold the subglottal pressure below and none above, and leak next to nothing") {
  const Slit slit(9);
  for (const double shut : {0.0, -2e-6}) {
    const FlowState flow = slit.flow({}, list({90e-6, 40e-6, 10e-6, shut, shut, 10e-6, 40e-6, 60e-6, 90e-6}));
    CHECK(!flow.stopped);
    CHECK(flow.flow > 0);
    CHECK(flow.flow < 0.1e-6);  // m^3/s, against some 200e-6 of an open glottis
    CHECK(flow.pressure.head(3).isApprox(Vector::Constant(3, 800), 0.02));
    CHECK(flow.pressure.tail(5).cwiseAbs().maxCoeff() < 0.02 * 800);
    CHECK(flow.separation == 5);
  }
}

TEST_CASE(
    "pressures and flow are continuous in all areas: their change is bounded by the areas' relative change") {
  // With areas in [m, ...] changed by at most eps each way, e and m change by eps, their squares by 2 eps, 1 / a^3
  // by 3 eps and the friction factor by at most 2 eps r / (r - 1). With K = U R' / p_s, R' the resistance of the
  // whole way as if the stream followed the wall, the pressures change by at most
  //   p_s eps (8 / e terms: 2 + 2 (r^2 - 1) + flow's own 2) + p_s eps K (3 + 2 r / (r - 1)) twice,
  // for which 40 (1 + K) p_s eps is an upper bound at r = 1.2.
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  const Slit slit(40);
  const ViscousSlit model;
  const double floor = model.least_gap * length * length;
  double largest = 0;
  for (const double eps : {1e-3, 1e-5, 1e-7})
    for (int trial = 0; trial < 2000; ++trial) {
      const Vector areas = random_areas(random, slit.height, trial % 3 / 2.0);
      Vector moved = areas;
      // A change of eps relative to the floored area.
      for (auto& a : moved) a += eps * std::max(a, floor) * unit(random);
      const FlowState one = slit.flow(model, areas), other = slit.flow(model, moved);
      double resistance = 0;
      for (int i = 0; i < 40; ++i)
        resistance +=
            12 * model.air_viscosity * length * length * 6e-3 / 39 / std::pow(std::max(areas[i], floor), 3);
      const double K = one.flow * resistance / air.subglottal_pressure;
      const double change = (one.pressure - other.pressure).cwiseAbs().maxCoeff() / air.subglottal_pressure;
      CHECK(change <= 40 * (1 + K) * eps);
      CHECK(std::abs(one.flow - other.flow) <= 40 * (1 + K) * eps * one.flow);
      largest = std::max(largest, change / eps);
    }
  CHECK(largest > 0.5);  // it does depend on the shape
}

TEST_CASE("the least section may jump and a hump may reach the ratio without a jump of the pressures") {
  const Slit slit(7);
  const double e = 1e-9;
  const auto differ = [&](const Vector& a, const Vector& b) {
    return (slit.flow({}, 1e-6 * a).pressure - slit.flow({}, 1e-6 * b).pressure).cwiseAbs().maxCoeff();
  };
  // Two equal throats, the least being the first or the second: with Bernoulli's the pressures between them jump.
  const Vector first = list({90, 5 - e, 30, 30, 5 + e, 30, 90}), second = list({90, 5 + e, 30, 30, 5 - e, 30, 90});
  CHECK(differ(first, second) < 1e4 * e);
  const Vector a = bernoulli_flow(air, 0, 1e-6 * first, false).pressure,
               b = bernoulli_flow(air, 0, 1e-6 * second, false).pressure;
  CHECK((a - b).cwiseAbs().maxCoeff() > 100);
  // A hump between throats at 1.2 times the first; a plateau there.
  CHECK(differ(list({90, 5, 6 - e, 6 - e, 5.5, 30, 90}), list({90, 5, 6 + e, 6 + e, 5.5, 30, 90})) < 1e4 * e);
  // Closing through zero.
  CHECK(differ(list({90, 5, e, e, 5.5, 30, 90}), list({90, 5, -e, -e, 5.5, 30, 90})) < 1e4 * e);
}

TEST_CASE("a pressure above shifts all others, and drives no flow; turned about, air flows back as it came") {
  const Slit slit(9);
  const Vector areas = 1e-6 * list({90, 60, 40, 20, 9, 5, 5.5, 30, 80});
  const double above = 250;
  const auto flows = [&](const Air& driven_by) {
    return std::array{slit.flow({}, areas, driven_by), bernoulli_flow(driven_by, 0, areas, false)};
  };
  const auto forth = flows(air), shifted = flows({air.subglottal_pressure + above, air.density, above}),
             back = flows({0, air.density, air.subglottal_pressure}), still = flows({above, air.density, above});
  for (std::size_t law = 0; law < 2; ++law) {
    REQUIRE(forth[law].flow > 0);
    CHECK(forth[law].supraglottal_pressure == 0);
    CHECK(shifted[law].flow == approx(forth[law].flow).epsilon(1e-14));
    CHECK(back[law].flow == -forth[law].flow);
    CHECK(back[law].jet_power == forth[law].jet_power);
    CHECK(back[law].viscous_power == forth[law].viscous_power);
    for (const auto* flow : {&shifted[law], &back[law]}) {
      const AirwayPressure walls = flow->on_walls();
      CHECK(flow->supplied_power == approx((walls.below - walls.above) * flow->flow).epsilon(1e-14));
      CHECK(flow->supplied_power == approx(flow->jet_power + flow->viscous_power).epsilon(1e-13));
    }
    for (int i = 0; i < 9; ++i) {
      CHECK(std::abs(shifted[law].pressure[i] - above - forth[law].pressure[i]) < 1e-11);
      CHECK(std::abs(back[law].pressure[i] - air.subglottal_pressure + forth[law].pressure[i]) < 1e-11);
    }
    CHECK(still[law].flow == 0);
    CHECK((still[law].pressure.array() == above).all());
  }
}

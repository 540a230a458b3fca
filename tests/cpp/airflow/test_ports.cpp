// The flow between two tubes, through walls that move: what it takes from the ones and gives to the others.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "../approx.hpp"
#include "plica/airflow/flow_model.hpp"
#include "plica/core/error.hpp"

using namespace plica;

namespace {

struct Glottis {
  Vector height = Vector::LinSpaced(8, 0.0, 4e-3);
  Vector length = Vector::Constant(8, 14e-3);
  Vector areas = Vector(8);
  AirwayExpansion moving;

  explicit Glottis(std::mt19937& random) {
    std::uniform_real_distribution<double> area(2e-6, 4e-5), rate(-1e-4, 1e-4);
    for (double& a : areas) a = area(random);
    moving.sections.resize(8);
    for (double& w : moving.sections) w = rate(random) / 8;
    moving.below = rate(random) / 8;
    moving.above = rate(random) / 8;
  }
  Channel channel() const { return {height, length}; }
};

Air between_tubes() {
  Air air;
  air.subglottal_pressure = 900;
  air.supraglottal_pressure = 40;
  air.subglottal_impedance = 8e5;
  air.supraglottal_impedance = 1.5e6;
  return air;
}

double power_on_walls(const FlowState& flow, const AirwayExpansion& moving) {
  return flow.subglottal_pressure * moving.below + flow.pressure.dot(moving.sections) +
         flow.supraglottal_pressure * moving.above;
}

/// What both models owe their ends and walls.
void check(const FlowState& flow, const Air& air, const AirwayExpansion& moving) {
  const double scale = 1e3 * 1e-3;  // W
  CHECK(flow.flow_below - flow.flow_above == approx(moving.total()).epsilon(1e-12));
  CHECK(flow.subglottal_pressure ==
        approx(air.subglottal_pressure - air.subglottal_impedance * flow.flow_below).epsilon(1e-12));
  CHECK(flow.supraglottal_pressure ==
        approx(air.supraglottal_pressure + air.supraglottal_impedance * flow.flow_above).epsilon(1e-12));
  const double in = flow.subglottal_pressure * flow.flow_below - flow.supraglottal_pressure * flow.flow_above;
  CHECK(std::abs(in - power_on_walls(flow, moving) - flow.jet_power - flow.viscous_power) < 1e-12 * scale);
}

}  // namespace

TEST_CASE("what enters a slit and does not leave it is what jet, friction and walls take") {
  std::mt19937 random(7);
  for (int i = 0; i < 50; ++i) {
    const Glottis glottis(random);
    ViscousSlit model;
    if (i % 3 == 1) model.air_viscosity = 0;
    if (i % 3 == 2) model.air_viscosity = 1e-2;
    Air air = between_tubes();
    if (i % 5 == 1) std::swap(air.subglottal_pressure, air.supraglottal_pressure);
    if (i % 5 == 2) air.supraglottal_impedance = 0;
    if (i % 5 == 3) air.subglottal_impedance = air.supraglottal_impedance = 0;
    check(viscous_slit_flow(model, air, glottis.channel(), glottis.areas, &glottis.moving), air, glottis.moving);
  }
}

TEST_CASE("a flow is found also where what walls displace decides it") {
  // Iterating the two alone goes to and fro: a tube far too narrow for the air that soft walls push.
  std::mt19937 random(12);
  std::uniform_real_distribution<double> share(0, 1);
  const auto between = [&](double low, double high) { return low * std::pow(high / low, share(random)); };
  for (int i = 0; i < 4000; ++i) {
    Glottis glottis(random);
    for (double& a : glottis.areas) a = between(1e-9, 1e-4);
    const double more = between(1e-6, 100);
    glottis.moving.sections *= more;
    glottis.moving.below *= more;
    glottis.moving.above *= more;
    ViscousSlit model;
    model.air_viscosity = between(1e-7, 1e-1);
    Air air;
    air.subglottal_pressure = between(1e-3, 1e5);
    air.subglottal_impedance = between(1e4, 1e9);
    air.supraglottal_impedance = between(1e4, 1e9);
    const FlowState flow = viscous_slit_flow(model, air, glottis.channel(), glottis.areas, &glottis.moving);
    const double in = flow.subglottal_pressure * flow.flow_below,
                 out = flow.supraglottal_pressure * flow.flow_above;
    const double walls = power_on_walls(flow, glottis.moving), lost = flow.jet_power + flow.viscous_power;
    const double scale =
        std::abs(in) + std::abs(out) + lost + flow.pressure.cwiseAbs().dot(glottis.moving.sections.cwiseAbs());
    CHECK(std::abs(in - out - walls - lost) < 1e-7 * scale);
  }
}

TEST_CASE("the same of Bernoulli's flow, also where contact stops it") {
  std::mt19937 random(8);
  for (int i = 0; i < 50; ++i) {
    const Glottis glottis(random);
    const Air air = between_tubes();
    const bool stopped = i % 2;
    const FlowState flow = bernoulli_flow(air, 1e-9, glottis.areas, stopped, std::nullopt, &glottis.moving);
    check(flow, air, glottis.moving);
    CHECK((flow.flow == 0) == stopped);
  }
}

TEST_CASE("between tubes a flow is what both and the glottis leave") {
  std::mt19937 random(9);
  const Glottis glottis(random);
  const Air air = between_tubes();
  const FlowState flow = viscous_slit_flow({}, air, glottis.channel(), glottis.areas);
  Air held;
  held.subglottal_pressure = flow.subglottal_pressure;
  held.supraglottal_pressure = flow.supraglottal_pressure;
  const FlowState same = viscous_slit_flow({}, held, glottis.channel(), glottis.areas);
  CHECK(same.flow == approx(flow.flow).epsilon(1e-12));
  CHECK((same.pressure - flow.pressure).cwiseAbs().maxCoeff() < 1e-9);
  CHECK(flow.flow_below == flow.flow);
  CHECK(flow.flow_above == flow.flow);
}

TEST_CASE("walls that move without a drop of pressure divide their air where the friction is") {
  std::mt19937 random(10);
  const Glottis glottis(random);
  Air air;
  air.subglottal_pressure = air.supraglottal_pressure = 0;
  const FlowState flow = viscous_slit_flow({}, air, glottis.channel(), glottis.areas, &glottis.moving);
  CHECK(flow.flow == 0);
  CHECK(flow.flow_below - flow.flow_above == approx(glottis.moving.total()));
  CHECK(std::isfinite(flow.flow_below));
}

TEST_CASE("walls of another number of sections are refused") {
  std::mt19937 random(11);
  Glottis glottis(random);
  glottis.moving.sections.resize(7);
  CHECK_THROWS_AS(viscous_slit_flow({}, {}, glottis.channel(), glottis.areas, &glottis.moving), InvalidInput);
  CHECK_THROWS_AS(bernoulli_flow({}, 0, glottis.areas, false, std::nullopt, &glottis.moving), InvalidInput);
  CHECK_THROWS_AS(AirwayPressure::of(Vector::Zero(1)), InvalidInput);
}

TEST_CASE("a pressure is what it is made of") {
  const AirwayPressure pressure{3.0, Vector::LinSpaced(4, 1.0, 2.0), 5.0};
  const AirwayPressure same = AirwayPressure::of(pressure.all());
  CHECK(same.same_ends(pressure));
  CHECK(same.sections == pressure.sections);
}

// The flow's answer to small changes, against closed forms and against the flow itself.
#include <doctest/doctest.h>

#include <cmath>

#include "../approx.hpp"
#include "plica/airflow/flow_tangent.hpp"
#include "tube.hpp"

using namespace plica;

namespace {

Airflow small_glottis(const Airflow::Options& options) {
  static const TetMesh mesh = slit(1e-3, 14e-3, 8e-3);
  return Airflow(mesh, mesh.surface("airway"), options);
}

Airflow::Options without_friction(int sections) {
  Airflow::Options options;
  options.model = ViscousSlit{1.2, 0.0, 3e-4};
  options.area = CutSections{sections};
  return options;
}

/// A throat in the middle, m^2.
Vector areas_with_a_throat(std::ptrdiff_t count) {
  Vector a(count);
  for (std::ptrdiff_t i = 0; i < count; ++i)
    a[i] = 1e-6 * (5 + 0.8 * std::pow(static_cast<double>(i - count / 2) - 0.3, 2));
  return a;
}

}  // namespace

TEST_CASE("without friction pressures answer to their own area and to the throat's as Bernoulli says") {
  const Airflow airflow = small_glottis(without_friction(9));
  const Vector a = areas_with_a_throat(9);
  const Air air{700.0, 1.2, 20.0};
  const FlowTangent found = flow_tangent(airflow, a, air);
  const double D = 680, r = 1.2, m = a[4];
  CHECK(found.kink < 1e-3);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 9; ++j) {
      const double own = 2 * D * r * r * m * m / std::pow(a[i], 3), throat = -2 * D * r * r * m / (a[i] * a[i]);
      const double expected = j == i ? own : j == 4 ? throat : 0.0;
      CHECK(std::abs(found.pressure_by_area(i, j) - expected) < 1e-7 * std::abs(throat));
    }
  for (int i = 6; i < 9; ++i) CHECK(found.pressure_by_area.row(i).cwiseAbs().maxCoeff() < 1e-3);
  const double U = std::sqrt(2 * D / 1.2) * r * m;
  CHECK(found.state.flow == approx(U).epsilon(1e-12));
  CHECK(found.flow_by_area[4] == approx(U / m).epsilon(1e-7));
  CHECK(found.flow_by_drop == approx(U / (2 * D)).epsilon(1e-7));
  for (int i = 0; i < 4; ++i)
    CHECK(found.pressure_by_drop[i] == approx(1 - std::pow(r * m / a[i], 2)).epsilon(1e-7));
}

TEST_CASE("a small change of areas and pressures with friction is that of the tangent, to second order") {
  Airflow::Options options = without_friction(24);
  options.model = ViscousSlit{};
  const Airflow airflow = small_glottis(options);
  const Vector a = 0.1 * areas_with_a_throat(24);
  const Air air{800.0, 1.2, 30.0};
  const FlowTangent found = flow_tangent(airflow, a, air);
  REQUIRE(found.pressure_by_area.cwiseAbs().maxCoeff() > 0);
  Vector way(24);
  for (int i = 0; i < 24; ++i) way[i] = a[i] * std::sin(2.3 * i + 0.4);
  std::vector<double> left;
  for (const double part : {1e-3, 5e-4}) {
    Air driven = air;
    driven.subglottal_pressure += 300 * part;
    driven.supraglottal_pressure -= 80 * part;
    const FlowState moved = airflow.evaluate(a + part * way, driven);
    const Vector predicted = found.state.pressure +
                             part * (found.pressure_by_area * way + 380 * found.pressure_by_drop) -
                             Vector::Constant(24, 80 * part);
    const double flow = found.state.flow + part * (found.flow_by_area.dot(way) + 380 * found.flow_by_drop);
    left.push_back((moved.pressure - predicted).norm());
    CHECK(std::abs(moved.flow - flow) < 20 * part * part * found.state.flow);
  }
  CHECK(left[0] > 0);
  CHECK(left[0] / left[1] == approx(4).epsilon(0.02));
}

TEST_CASE("what walls displace comes from below by the tangent's share") {
  Airflow::Options options = without_friction(12);
  options.model = ViscousSlit{};
  const Airflow airflow = small_glottis(options);
  const Vector a = 0.2 * areas_with_a_throat(12);
  const Air air{800.0, 1.2};
  const FlowTangent found = flow_tangent(airflow, a, air);
  AirwayExpansion moving{2e-7, Vector(12), -1e-7};
  for (int i = 0; i < 12; ++i) moving.sections[i] = 1e-6 * std::cos(0.9 * i);
  const FlowState state = airflow.evaluate(a, air, false, std::nullopt, &moving);
  CHECK(state.flow_below - state.flow == approx(2e-7 + found.from_below.dot(moving.sections)).epsilon(1e-9));
}

TEST_CASE("two equal throats are a kink, and a flow that has no drop has no tangent") {
  const Airflow airflow = small_glottis(without_friction(9));
  Vector a = areas_with_a_throat(9);
  a[6] = a[4];
  CHECK(flow_tangent(airflow, a, {700.0, 1.2}).kink > 0.1);
  CHECK_THROWS_AS(flow_tangent(airflow, a, {0.0, 1.2}), InvalidInput);
  CHECK_THROWS_AS(flow_tangent(airflow, a, {700.0, 1.2, 0.0, 1e5, 0.0}), InvalidInput);
}

TEST_CASE("the thesis's flow answers with its section of separation held") {
  Airflow::Options options = without_friction(9);
  options.model = Bernoulli{};
  const Airflow airflow = small_glottis(options);
  const Vector a = areas_with_a_throat(9);
  const FlowTangent found = flow_tangent(airflow, a, {700.0, 1.2});
  CHECK(found.state.separation == 4);
  CHECK(found.pressure_by_area(2, 4) == approx(-2 * 700 * a[4] / (a[2] * a[2])).epsilon(1e-7));
  CHECK(found.pressure_by_area.bottomRows(5).cwiseAbs().maxCoeff() == 0);
}

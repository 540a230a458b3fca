// What drives the flow in a step, and what the air remembers of it.
#include <doctest/doctest.h>

#include "plica/airflow/air_column.hpp"
#include "plica/core/error.hpp"
#include "tube.hpp"

using namespace plica;
using Instant = AirColumn::Instant;

namespace {

Airflow rising(double rise) {
  const TetMesh mesh = tube(
      16, {-2e-2, -1e-2, 0.5e-2, 1e-2}, [](double z) { return 0.2e-2 - 0.1 * z; }, 0.7e-2);
  Airflow::Options options;
  options.model = Bernoulli{};
  options.area = EllipticSections{};
  options.rise = rise;
  return {mesh, mesh.surface("airway"), options};
}

}  // namespace

TEST_CASE("a step's flow is driven by the air of its own instants") {
  const Airflow airflow = rising(1e-3);
  AirColumn column(airflow);
  const Vector areas = Vector::LinSpaced(airflow.sections().count(), 2e-5, 1e-5);
  column.begin_step({}, 2e-4, 5e-5);
  for (const auto& [at, time] : {std::pair(Instant::last, 2e-4), std::pair(Instant::weighted, 2.5e-4)}) {
    const FlowState expected = airflow.evaluate(areas, airflow.air(time));
    CHECK(column.air(at).subglottal_pressure == airflow.air(time).subglottal_pressure);
    CHECK(column.evaluate(areas, at).pressure == expected.pressure);
    CHECK(column.evaluate(areas, at).flow == expected.flow);
  }
  CHECK(column.air(Instant::last).subglottal_pressure < column.air(Instant::weighted).subglottal_pressure);
}

TEST_CASE("the air remembers whether contact stopped it until it says otherwise") {
  const Airflow airflow = rising(0.0);
  AirColumn column(airflow);
  const Vector areas = Vector::LinSpaced(airflow.sections().count(), 2e-5, 1e-5);
  column.begin_step({true}, 0.0, 1e-4);
  CHECK(column.stopped());
  CHECK(column.evaluate(areas, Instant::weighted).flow == 0);
  column.stop(false);
  CHECK(column.evaluate(areas, Instant::weighted).flow > 0);
  CHECK_FALSE(column.end_step().flow_stopped);
  column.begin_step(column.end_step(), 1e-4, 1e-4);
  CHECK_FALSE(column.stopped());
}

TEST_CASE("what an evaluation holds is held, whatever the areas and the memory") {
  const Airflow airflow = rising(0.0);
  AirColumn column(airflow);
  const std::ptrdiff_t count = airflow.sections().count();
  const Vector areas = Vector::LinSpaced(count, 2e-5, 1e-5);
  column.begin_step({true}, 0.0, 1e-4);
  const FlowState held = column.evaluate(areas, Instant::weighted, AirColumn::Held{false, 1});
  const FlowState expected = airflow.evaluate(areas, airflow.air(1e-4), false, 1);
  CHECK(held.separation == 1);
  CHECK(held.flow == expected.flow);
  CHECK(held.pressure == expected.pressure);
}

TEST_CASE("the memory of the air is what its numbers say, and starts with none") {
  for (const bool stopped : {true, false}) {
    const AirColumn::Memory memory{stopped};
    CHECK(AirColumn::Memory::of(memory.numbers()).flow_stopped == stopped);
  }
  CHECK_THROWS_AS(AirColumn::Memory::of({}), InvalidInput);
  CHECK_THROWS_AS(AirColumn::Memory::of({1, 0}), InvalidInput);
  const Airflow airflow = rising(1e-3);
  AirColumn column(airflow);
  const Vector areas = Vector::LinSpaced(airflow.sections().count(), 2e-5, 1e-5);
  column.begin_step({true}, 5e-3, 1e-4);
  CHECK(column.start(areas).subglottal_pressure == 0);  // at t = 0, not of the step before
  CHECK_FALSE(column.end_step().flow_stopped);
}

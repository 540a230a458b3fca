// What drives the flow in a step, and what the air remembers of it.
#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "../approx.hpp"
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

AirColumn::Memory stopped_or_not(bool stopped) {
  AirColumn::Memory memory;
  memory.flow_stopped = stopped;
  return memory;
}

}  // namespace

TEST_CASE("a step's flow is driven by the air of its own instants") {
  const Airflow airflow = rising(1e-3);
  AirColumn column(airflow, 1e-4);
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
  AirColumn column(airflow, 1e-4);
  const Vector areas = Vector::LinSpaced(airflow.sections().count(), 2e-5, 1e-5);
  column.begin_step(stopped_or_not(true), 0.0, 1e-4);
  CHECK(column.stopped());
  CHECK(column.evaluate(areas, Instant::weighted).flow == 0);
  column.stop(false);
  CHECK(column.evaluate(areas, Instant::weighted).flow > 0);
  CHECK_FALSE(column.end_step({}).flow_stopped);
  column.begin_step(column.end_step({}), 1e-4, 1e-4);
  CHECK_FALSE(column.stopped());
}

TEST_CASE("what an evaluation holds is held, whatever the areas and the memory") {
  const Airflow airflow = rising(0.0);
  AirColumn column(airflow, 1e-4);
  const std::ptrdiff_t count = airflow.sections().count();
  const Vector areas = Vector::LinSpaced(count, 2e-5, 1e-5);
  column.begin_step(stopped_or_not(true), 0.0, 1e-4);
  const FlowState held = column.evaluate(areas, Instant::weighted, AirColumn::Held{false, 1});
  const FlowState expected = airflow.evaluate(areas, airflow.air(1e-4), false, 1);
  CHECK(held.separation == 1);
  CHECK(held.flow == expected.flow);
  CHECK(held.pressure == expected.pressure);
}

TEST_CASE("the memory of the air is what its numbers say, and starts with none") {
  for (const bool stopped : {true, false}) {
    const AirColumn::Memory memory = stopped_or_not(stopped);
    CHECK(AirColumn::Memory::of(memory.numbers()).flow_stopped == stopped);
  }
  CHECK_THROWS_AS(AirColumn::Memory::of({}), InvalidInput);
  CHECK_THROWS_AS(AirColumn::Memory::of({1}), InvalidInput);
  const auto with = [](std::size_t count, std::initializer_list<std::pair<std::size_t, double>> set) {
    std::vector<double> numbers(count, 0.0);
    for (const auto& [at, value] : set) numbers[at] = value;
    return AirColumn::Memory::of(numbers);
  };
  for (const double first : {0.5, -1.0, 2.0, double{NAN}}) CHECK_THROWS_AS(with(18, {{0, first}}), InvalidInput);
  for (const std::size_t size : {1, 2, 3, 4, 5})
    for (const double wrong : {0.5, -1.0, 1e300, double{NAN}})
      CHECK_THROWS_AS(with(18, {{size, wrong}}), InvalidInput);
  CHECK_THROWS_AS(with(19, {}), InvalidInput);
  CHECK_THROWS_AS(with(20, {{4, 3}}), InvalidInput);  // of the trachea
  CHECK(with(21, {{4, 3}}).trachea.size() == 3);
  CHECK_THROWS_AS(with(23, {{1, 1}, {2, 3}}), InvalidInput);  // a secant of three pressures
  CHECK(with(24, {{1, 1}, {2, 3}}).secants[0].residual.size() == 3);
  CHECK_THROWS_AS(with(27, {{3, 5}}), InvalidInput);  // momenta of five sections
  CHECK(with(28, {{3, 5}}).momentum_before.size() == 5);
  const Airflow airflow = rising(1e-3);
  AirColumn column(airflow, 1e-4);
  const Vector areas = Vector::LinSpaced(airflow.sections().count(), 2e-5, 1e-5);
  column.begin_step(stopped_or_not(true), 5e-3, 1e-4);
  CHECK(column.start(areas).subglottal_pressure == 0);  // at t = 0, not of the step before
  CHECK_FALSE(column.end_step({}).flow_stopped);
}

TEST_CASE("a steady flow between tubes goes on as it began") {
  const Airflow airflow = rising(0.0);
  Tubes tubes;
  tubes.trachea = Tube{{0.15}, {2e-4}, PressureSupply{0.2}};
  tubes.tract = Tube{{0.17}, {3e-4}, Radiation{}, YieldingWall{}};
  AirColumn column(airflow, 1e-4, tubes);
  const Vector areas = Vector::LinSpaced(airflow.sections().count(), 2e-5, 1e-5);
  const FlowState first = column.start(areas);
  CHECK(first.subglottal_pressure < airflow.options().subglottal_pressure);
  CHECK(first.supraglottal_pressure > 0);
  AirColumn::Memory memory = column.remembered();
  CHECK(AirColumn::Memory::of(memory.numbers()).numbers() == memory.numbers());
  for (const double last : {1.0, 2.0, 3.0})
    column.remember({Vector::Constant(4, last), Vector::Constant(4, -last)});
  const AirColumn::Memory learned = AirColumn::Memory::of(column.remembered().numbers());
  CHECK(learned.numbers() == column.remembered().numbers());
  CHECK(learned.secants.size() == 2);
  CHECK(learned.secants[1].residual == Vector::Constant(4, -3.0));
  CHECK(learned.tract == memory.tract);
  for (int i = 0; i < 50; ++i) {
    column.begin_step(memory, i * 1e-4, 0.7e-4);
    const FlowState flow = column.evaluate(areas, Instant::weighted);
    CHECK(flow.flow == approx(first.flow).epsilon(1e-9));
    CHECK(flow.subglottal_pressure == approx(first.subglottal_pressure).epsilon(1e-9));
    memory = column.end_step(flow);
  }
  // Nothing is stored: the supply gives what the glottis and friction take. The first step is shorter.
  const double time = 49 * 1e-4 + 0.7e-4;
  const LineWork &below = memory.trachea_work, &above = memory.tract_work;
  CHECK(below.source == approx(time * airflow.options().subglottal_pressure * first.flow).epsilon(1e-9));
  CHECK(below.port == approx(-time * first.subglottal_pressure * first.flow).epsilon(1e-9));
  CHECK(above.port == approx(time * first.supraglottal_pressure * first.flow).epsilon(1e-9));
  CHECK(above.lost == approx(above.port).epsilon(1e-9));
  CHECK(column.lip_flow(memory) == approx(first.flow).epsilon(1e-9));
  CHECK(column.supply_rise(memory) == 1.0);
  AirColumn again(airflow, 1e-4, tubes);
  again.start(areas);
  CHECK(column.tube_energy(memory) == approx(again.tube_energy(again.remembered())).epsilon(1e-9));
}

TEST_CASE("a flow that is supplied rises from none and has to pass the glottis") {
  const Airflow airflow = rising(2e-3);
  Tubes tubes;
  tubes.trachea = Tube{{0.1}, {2e-4}, FlowSupply{1e-5, 3e-5}};
  AirColumn column(airflow, 1e-4, tubes);
  const Vector areas = Vector::LinSpaced(airflow.sections().count(), 2e-5, 1e-5);
  CHECK(column.start(areas).flow == 0);
  AirColumn::Memory memory = column.remembered();
  FlowState flow;
  for (int i = 0; i < 3000; ++i) {
    column.begin_step(memory, i * 1e-4, 1e-4);
    flow = column.evaluate(areas, Instant::weighted);
    memory = column.end_step(flow);
    if (i == 9) CHECK(column.supply_rise(memory) == approx(0.5).epsilon(1e-12));
  }
  CHECK(column.supply_rise(memory) == 1.0);
  CHECK(flow.flow == approx(3e-5).epsilon(1e-6));
  const double jet = 0.5 * airflow.options().air_density * std::pow(3e-5 / areas.minCoeff(), 2);
  CHECK(flow.subglottal_pressure == approx(jet).epsilon(1e-5));
}

TEST_CASE("the air of tubes is that of the flow, whose model may have none of its viscosity") {
  Airflow::Options options;
  options.air_density = 1.1;
  options.model = ViscousSlit{1.2, 2.5e-5};
  Gas gas = gas_of(options, 345);
  CHECK(gas.density == 1.1);
  CHECK(gas.sound_speed == 345);
  CHECK(gas.viscosity == 2.5e-5);
  CHECK_FALSE(options.has_inertance());
  options.model = ViscousSlit{1.2, 1.8e-5, 3e-4, true};
  CHECK(options.has_inertance());
  options.model = Bernoulli{};
  CHECK_FALSE(options.has_inertance());
  CHECK(gas_of(options, 345).viscosity == Gas{}.viscosity);
}

TEST_CASE("tubes that nothing drives, or that drive what they must not, are refused") {
  const Airflow at_once = rising(0.0), later = rising(1e-3);
  const auto said = [](const Airflow& airflow, const Tubes& tubes) {
    try {
      const AirColumn column(airflow, 1e-4, tubes);
      return std::string();
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
  };
  Tubes tubes;
  tubes.trachea = Tube{{0.1}, {2e-4}, Radiation{}};
  CHECK(said(later, tubes).find("must be a supply") != std::string::npos);
  tubes.trachea->end = FlowSupply{};
  CHECK(said(later, tubes).find("Nothing else drives") != std::string::npos);
  tubes.trachea->end = FlowSupply{0.0, 1e-4};
  CHECK(said(later, tubes).empty());
  CHECK(said(at_once, tubes).find("begins in still air") != std::string::npos);
  tubes.trachea.reset();
  tubes.tract = Tube{{0.1}, {2e-4}, FlowSupply{}};
  CHECK(said(later, tubes).empty());
  CHECK(said(at_once, tubes).find("begins in still air") != std::string::npos);
  tubes.tract = Tube{{0.1}, {2e-4}, FlowSupply{0.0, 1e-4}};
  CHECK(said(later, tubes).find("Its end is not driven") != std::string::npos);
}

TEST_CASE("a step without duration leaves the tubes as they are") {
  const Airflow airflow = rising(0.0);
  Tubes tubes;
  tubes.tract = Tube{{0.17}, {3e-4}};
  AirColumn column(airflow, 1e-4, tubes);
  const Vector areas = Vector::LinSpaced(airflow.sections().count(), 2e-5, 1e-5);
  column.start(areas);
  const AirColumn::Memory memory = column.remembered();
  column.begin_step(memory, 0.0, 1e-4, Instant::last);
  CHECK(column.end_step(column.evaluate(areas, Instant::last)).tract == memory.tract);
  tubes.sound_speed = 0;
  CHECK_THROWS_AS(AirColumn(airflow, 1e-4, tubes), InvalidInput);
}

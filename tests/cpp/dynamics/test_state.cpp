#include <doctest/doctest.h>

#include <limits>

#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

void check_equal(const State& a, const State& b) {
  CHECK(a.step == b.step);
  CHECK(a.displacement == b.displacement);
  CHECK(a.velocity == b.velocity);
  CHECK(a.acceleration == b.acceleration);
  CHECK(a.load == b.load);
  CHECK(a.contact_force == b.contact_force);
  CHECK(a.closed == b.closed);
  CHECK(a.flow_stopped == b.flow_stopped);
  CHECK(a.ledger.error() == b.ledger.error());
  CHECK(a.ledger.contact_work == b.ledger.contact_work);
}

}  // namespace

TEST_CASE("a restored state continues to the last bit, flow and contact included") {
  const Simulation::Options o = options(HilberHughesTaylor{}, 1e-4, 1e-8);
  Simulation whole(scenes::small_larynx(), o), first(scenes::small_larynx(), o), second(scenes::small_larynx(), o);
  bool touched = false, flowed = false;
  for (int k = 0; k < 24; ++k) {
    whole.advance();
    touched = touched || whole.record().contact->rows > 0;
    flowed = flowed || whole.record().flow->state.flow > 0;
    if (k < 9) first.advance();
  }
  CHECK(touched);
  CHECK(flowed);
  second.restore(first.state());
  for (int k = 9; k < 24; ++k) second.advance();
  check_equal(whole.state(), second.state());
  CHECK(whole.record().flow->state.pressure == second.record().flow->state.pressure);
  CHECK(whole.record().iterations == second.record().iterations);
  CHECK(whole.contact_pressure() == second.contact_pressure());
}

TEST_CASE("one thread and two give the same bits") {
  const Simulation::Options o = options(HilberHughesTaylor{}, 1e-4, 1e-8);
  Simulation one(scenes::small_larynx(), o), two(scenes::small_larynx(), o);
  for (int k = 0; k < 15; ++k) {
    set_threads(1);
    one.advance();
    set_threads(2);
    two.advance();
  }
  set_threads(1);
  check_equal(one.state(), two.state());
}

TEST_CASE("what a scene lacks does not exist") {
  Simulation simulation(scenes::held_block(), options(HilberHughesTaylor{}, 1e-4));
  simulation.advance();
  CHECK_FALSE(simulation.airflow().has_value());
  CHECK_FALSE(simulation.collision().has_value());
  CHECK_FALSE(simulation.viscosity().has_value());
  CHECK_FALSE(simulation.record().flow.has_value());
  CHECK_FALSE(simulation.record().contact.has_value());
  CHECK(simulation.state().contact_force.isZero(0));
  CHECK(simulation.contact_pressure().isZero(0));
}

TEST_CASE("contact pressure is zero before the first step and after a return to rest") {
  Simulation simulation(scenes::two_bars(4, Multipliers{}), options(HilberHughesTaylor{}, 1e-4));
  CHECK(simulation.contact_pressure().isZero(0));
  const State rest = simulation.state();
  simulation.advance();
  CHECK(simulation.contact_pressure().maxCoeff() > 0);
  simulation.restore(rest);
  CHECK(simulation.contact_pressure().isZero(0));
}

TEST_CASE("a force of the embedder's own accelerates as a load does") {
  Simulation simulation(scenes::tissue_scene(block_mesh({{0, 0, 0}, {0.01, 0.01, 0.01}, {1, 1, 1}}), 0.3, 0.0),
                        options(Newmark{}, 1e-4));
  Vector force = simulation.mass() * Vector::Constant(24, 3.0);  // 3 m/s^2 in every direction
  simulation.set_external_force(force);
  simulation.advance();
  simulation.advance();
  CHECK((simulation.state().acceleration.array() - 3.0).abs().maxCoeff() < 1e-9);
  CHECK_THROWS_AS(simulation.set_external_force(Vector::Zero(7)), InvalidInput);
}

TEST_CASE("scenes that do not fit are refused") {
  const Simulation::Options o = options(HilberHughesTaylor{}, 1e-4);
  Scene scene = scenes::held_block();
  scene.velocity = Points::Zero(3, 3);
  CHECK_THROWS_AS(Simulation(scene, o), InvalidInput);
  scene = scenes::held_block();
  scene.displacement = Points::Constant(scene.mesh.node_count(), 3, std::numeric_limits<double>::quiet_NaN());
  CHECK_THROWS_AS(Simulation(scene, o), InvalidInput);
  scene = scenes::held_block();
  scene.supports = Supports(2);
  CHECK_THROWS_AS(Simulation(scene, o), InvalidInput);
  scene = scenes::held_block();
  scene.loads = {{"no such surface", {1, 0, 0}, 0.0, 0.0}};
  CHECK_THROWS_AS(Simulation(scene, o), InvalidInput);
  CHECK_THROWS_AS(Simulation(scenes::two_bars(4, Penalty{0.0}), o), InvalidInput);
  CHECK_THROWS_AS(Simulation(scenes::two_bars(4, VolumePenalty{-1.0}), o), InvalidInput);
  scene = scenes::two_bars(4, Multipliers{});
  scene.contact->options.tolerance = 0;
  CHECK_THROWS_AS(Simulation(scene, o), InvalidInput);
  Simulation held(scenes::held_block(), o);
  CHECK_THROWS_AS(held.restore(State{}), InvalidInput);
}

TEST_CASE("a step whose solve does not converge names its time and leaves the last state") {
  Simulation::Options o = options(HilberHughesTaylor{}, 1e-2, 1e-8);
  o.solver.max_iterations = 1;  // too few for any motion; at rest without load none is needed
  Scene scene = scenes::held_block();
  Simulation simulation(scene, o);
  Vector force = Vector::Zero(simulation.step_matrix().rows());
  for (const auto node : scene.mesh.node_set("x_max")) force[3 * node + 1] = 1e-3;
  simulation.set_external_force(force);
  CHECK_THROWS_WITH_AS(simulation.advance(), doctest::Contains("t = 0.01 s"), SolveFailed);
  CHECK(simulation.state().step == 0);
  CHECK(simulation.state().displacement.isZero(0));
}

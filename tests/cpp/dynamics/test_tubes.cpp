// Voices between a trachea and a vocal tract. What they have in common with inertia: test_inertance.cpp.
#include <doctest/doctest.h>

#include "../approx.hpp"
#include "voice_scenes.hpp"

using namespace plica;
using scenes::options;
using scenes::relative;
using scenes::voice;

TEST_CASE("tubes change a voice, and pressures at their ends are theirs") {
  const Simulation::Options how = options(HilberHughesTaylor{}, 1e-4, 1e-12);
  Scene without = voice(true, false);
  without.airflow->tubes = {};
  Simulation one(voice(true, false), how), other(without, how);
  for (int i = 0; i < 20; ++i) {
    one.advance();
    other.advance();
    const FlowState& flow = one.record().flow->state;
    CHECK(one.record().flow->converged);
    CHECK(flow.subglottal_pressure == approx(one.state().air.trachea[0]).epsilon(1e-9));
    CHECK(flow.supraglottal_pressure == approx(one.state().air.tract[0]).epsilon(1e-9));
    CHECK(std::abs(one.state().ledger.error()) < 1e-9 * one.state().ledger.kinetic + 1e-14);
  }
  CHECK(relative(one.displacement(), other.displacement()) > 1e-3);
}

TEST_CASE("a tube as wide as a hall is none") {
  const Simulation::Options how = options(HilberHughesTaylor{}, 1e-4, 1e-12);
  Scene wide = voice(true, false);
  wide.airflow->coupling = Iterated{1e-9};
  Scene without = wide;
  without.airflow->tubes = {};
  wide.airflow->tubes.trachea = Tube{{0.1}, {1e6}, PressureSupply{}};
  wide.airflow->tubes.tract = Tube{{0.1}, {1e6}, Radiation{}};
  Simulation one(wide, how), other(without, how);
  for (int i = 0; i < 20; ++i) {
    one.advance();
    other.advance();
  }
  CHECK(relative(one.displacement(), other.displacement()) < 1e-8);
}

TEST_CASE("couplings and explicit steps come to the same, between tubes too, as steps get short") {
  scenes::check_short_steps(voice(true, false));
}

TEST_CASE("couplings between tubes learn from the steps before: fewer sweeps to the same motion") {
  for (const bool reduced : {false, true}) {
    Scene scene = voice(true, false);
    if (reduced) scene = scenes::reduced(scene, scenes::every_displacement(scene));
    const Simulation::Options how = options(HilberHughesTaylor{}, 1e-5, 1e-12);
    Simulation learning(scene, how), forgetting(scene, how);
    int sweeps = 0, without = 0;
    for (int i = 0; i < 40; ++i) {
      learning.advance();
      sweeps += learning.record().flow->sweeps;
      State forgotten = forgetting.state();
      forgotten.air.secants.clear();
      forgetting.restore(forgotten);
      forgetting.advance();
      without += forgetting.record().flow->sweeps;
    }
    CHECK(sweeps < 0.9 * without);
    CHECK(relative(learning.displacement(), forgetting.displacement()) < 1e-5);
    State kept = learning.state();
    CHECK(kept.air.secants.size() == 2);
    kept.air.secants[1].residual = Vector::Ones(3);
    CHECK_THROWS_AS(learning.restore(kept), InvalidInput);
    kept = learning.state();
    kept.air.secants[0].image[0] = NAN;
    CHECK_THROWS_AS(learning.restore(kept), InvalidInput);
  }
}

TEST_CASE("without flow of its own a supply fills tubes that are still at first") {
  Scene scene = voice(true, false);
  scene.airflow->flow.rise = 2e-3;
  Simulation simulation(scene, options(HilberHughesTaylor{}, 1e-4, 1e-12));
  CHECK(simulation.state().air.trachea.isZero(0));
  for (int i = 0; i < 5; ++i) simulation.advance();
  const double early = simulation.state().air.trachea[0];
  for (int i = 0; i < 15; ++i) simulation.advance();
  CHECK(early > 0);
  CHECK(simulation.state().air.trachea[0] > early);
}

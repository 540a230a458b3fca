// Voices between a trachea and a vocal tract: all steps give the same, the air's power is that of the tissue.
#include <doctest/doctest.h>

#include "../approx.hpp"
#include "voice_scenes.hpp"

using namespace plica;
using scenes::options;
using scenes::power_on_walls;
using scenes::relative;

namespace {

Tubes tubes() {
  Tubes both;
  both.trachea = Tube{{0.12}, {2e-4}, PressureSupply{0.5}, {}, 1000.0};
  both.tract = Tube{{0.03, 0.14}, {0.6e-4, 4e-4}, Radiation{}, YieldingWall{}, 1000.0};
  return both;
}

Scene voice(Scene scene) {
  scene.airflow->flow.model = ViscousSlit{};
  scene.airflow->flow.area = CutSections{8};
  scene.airflow->tubes = tubes();
  return scene;
}

}  // namespace

TEST_CASE("tubes change a voice, and pressures at their ends are theirs") {
  const Simulation::Options how = options(HilberHughesTaylor{}, 1e-4, 1e-12);
  Scene without = voice(scenes::larynx_folds());
  without.airflow->tubes = {};
  Simulation one(voice(scenes::larynx_folds()), how), other(without, how);
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
  Scene wide = voice(scenes::larynx_folds());
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

TEST_CASE("a voice in all displacements is that of its nodes, between tubes too") {
  const Scene scene = voice(scenes::larynx_folds());
  for (const TimeScheme& scheme : scenes::cases<TimeScheme>({HilberHughesTaylor{}, Newmark{}})) {
    Simulation full(scene, options(scheme, 1e-4, 1e-12));
    Simulation reduced(scenes::reduced(scene, scenes::every_displacement(scene)), options(scheme, 1e-4, 1e-12));
    for (int i = 0; i < 20; ++i) {
      full.advance();
      reduced.advance();
    }
    CHECK(relative(reduced.displacement(), full.displacement()) < 1e-5);
    CHECK(reduced.record().flow->state.flow_below == approx(full.record().flow->state.flow_below).epsilon(1e-4));
  }
}

TEST_CASE("couplings and explicit steps come to the same, between tubes too, as steps get short") {
  scenes::check_short_steps(voice(scenes::larynx_folds()));
}

TEST_CASE("what leaves the trachea and does not enter the tract is what jet, friction and tissue take") {
  const auto off = [](double step) {
    Scene scene = voice(scenes::larynx_folds());
    scene.contact.reset();
    Simulation simulation(scene, options(Newmark{}, step, 1e-12));
    double air = 0, before = 0;
    const Airflow& airflow = *simulation.airflow();
    for (int i = 0; simulation.time() < 2e-3 - 1e-9; ++i) {
      simulation.advance();
      const FlowState& flow = simulation.record().flow->state;
      const Vector velocity =
          as_points(simulation.velocity())(airflow.nodes(), Eigen::all).reshaped<Eigen::RowMajor>();
      const AirwayExpansion moving = airflow.load_patterns().expansion(velocity);
      const double in = flow.subglottal_pressure * flow.flow_below - flow.supraglottal_pressure * flow.flow_above;
      const double tissue = in - flow.jet_power - flow.viscous_power;
      CHECK(tissue == approx(power_on_walls(flow, moving)).epsilon(1e-3));
      CHECK(flow.flow_below - flow.flow_above == approx(moving.total()).epsilon(1e-4));
      if (i > 0) air += 0.5 * step * (before + tissue);
      if (i == 0) air = simulation.state().ledger.flow_work;
      before = tissue;
    }
    return std::abs(air / simulation.state().ledger.flow_work - 1);
  };
  const double coarse = off(4e-5), fine = off(2e-5);
  CHECK(fine < 5e-3);
  CHECK(coarse / fine > 2);
}

TEST_CASE("a run that is continued goes on with the sound in its tubes, bit for bit") {
  const Scene scene = voice(scenes::larynx_folds());
  for (const Coupling& coupling : scenes::cases<Coupling>({Iterated{}, Extrapolated{}, Lagged{}}))
    for (const bool reduced : {false, true}) {
      Scene each = scene;
      each.airflow->coupling = coupling;
      if (reduced) each = scenes::reduced(each, scenes::every_displacement(each));
      const Simulation::Options how = options(HilberHughesTaylor{}, 1e-4, 1e-12);
      Simulation whole(each, how), second(each, how);
      for (int i = 0; i < 5; ++i) whole.advance();
      State kept = whole.state();
      kept.air = AirColumn::Memory::of(kept.air.numbers());
      second.restore(kept);
      for (int i = 0; i < 5; ++i) {
        whole.advance();
        second.advance();
      }
      CHECK(second.displacement() == whole.displacement());
      CHECK(second.state().air.tract == whole.state().air.tract);
      CHECK(second.state().air.trachea == whole.state().air.trachea);
      CHECK(second.state().air.numbers() == whole.state().air.numbers());
      kept.air.tract = Vector::Zero(3);
      CHECK_THROWS_AS(second.restore(kept), InvalidInput);
      kept.air = whole.state().air;
      kept.air.trachea[1] = NAN;
      CHECK_THROWS_AS(second.restore(kept), InvalidInput);
      kept.air = whole.state().air;
      kept.air.flow_below = INFINITY;
      CHECK_THROWS_AS(second.restore(kept), InvalidInput);
    }
}

TEST_CASE("symmetric folds between tubes are a half of the whole") {
  Scene scene = voice(scenes::symmetric_folds());
  scene.airflow->coupling = Iterated{1e-9};
  Simulation whole(scene, options(HilberHughesTaylor{}, 1e-4, 1e-12));
  scene.symmetry = Symmetry::half;
  Simulation half(scene, options(HilberHughesTaylor{}, 1e-4, 1e-12));
  for (int i = 0; i < 15; ++i) {
    whole.advance();
    half.advance();
  }
  CHECK(relative(half.displacement(), whole.displacement()) < 1e-6);
  CHECK(half.state().air.flow_below == approx(whole.state().air.flow_below).epsilon(1e-6));
  CHECK(half.state().air.flow_above == approx(whole.state().air.flow_above).epsilon(1e-6));
}

TEST_CASE("couplings between tubes learn from the steps before: fewer sweeps to the same motion") {
  for (const bool reduced : {false, true}) {
    Scene scene = voice(scenes::larynx_folds());
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
  Scene scene = voice(scenes::larynx_folds());
  scene.airflow->flow.rise = 2e-3;
  Simulation simulation(scene, options(HilberHughesTaylor{}, 1e-4, 1e-12));
  CHECK(simulation.state().air.trachea.isZero(0));
  for (int i = 0; i < 5; ++i) simulation.advance();
  const double early = simulation.state().air.trachea[0];
  for (int i = 0; i < 15; ++i) simulation.advance();
  CHECK(early > 0);
  CHECK(simulation.state().air.trachea[0] > early);
}

// Voices whose air remembers, in tubes or by inertia: all steps give the same, its power is that of the tissue,
// runs go on.
#include <doctest/doctest.h>

#include "../approx.hpp"
#include "voice_scenes.hpp"

using namespace plica;
using scenes::options;
using scenes::power_on_walls;
using scenes::relative;
using scenes::voice;

namespace {

struct Remembering {
  bool tubes, inertance;
};
constexpr Remembering ways[] = {{true, false}, {false, true}, {true, true}};

}  // namespace

TEST_CASE("inertance changes a voice") {
  for (const bool tubes : {false, true}) {
    Simulation one(voice(tubes, true), options(HilberHughesTaylor{}, 1e-4, 1e-12));
    Simulation other(voice(tubes, false), options(HilberHughesTaylor{}, 1e-4, 1e-12));
    for (int i = 0; i < 20; ++i) {
      one.advance();
      other.advance();
      CHECK(one.record().flow->converged);
      CHECK(std::abs(one.state().ledger.error()) < 1e-9 * one.state().ledger.kinetic + 1e-14);
    }
    CHECK(relative(one.displacement(), other.displacement()) > 1e-4);
    CHECK(one.state().ledger.air_inertial_energy != 0);
    CHECK(other.state().ledger.air_inertial_energy == 0);
  }
}

TEST_CASE("a voice in all displacements is that of its nodes, with tubes and inertance too") {
  for (const auto& [tubes, inertance] : ways) {
    const Scene scene = voice(tubes, inertance);
    for (const TimeScheme& scheme : scenes::cases<TimeScheme>({HilberHughesTaylor{}, Newmark{}})) {
      CAPTURE(tubes);
      CAPTURE(inertance);
      Simulation full(scene, options(scheme, 1e-4, 1e-12));
      Simulation reduced(scenes::reduced(scene, scenes::every_displacement(scene)), options(scheme, 1e-4, 1e-12));
      for (int i = 0; i < 20; ++i) {
        full.advance();
        reduced.advance();
      }
      CHECK(relative(reduced.displacement(), full.displacement()) < 1e-5);
      CHECK(reduced.record().flow->state.flow_below == approx(full.record().flow->state.flow_below).epsilon(1e-4));
      CHECK(reduced.state().ledger.air_inertial_energy ==
            approx(full.state().ledger.air_inertial_energy).epsilon(1e-4));
      if (inertance) CHECK(reduced.state().air.momentum[7] == approx(full.state().air.momentum[7]).epsilon(1e-4));
    }
  }
}

TEST_CASE("couplings and explicit steps come to the same with inertance, as steps get short") {
  scenes::check_short_steps(voice(false, true));
}

TEST_CASE("what leaves the trachea and does not enter the tract is what jet, friction, inertia and tissue take") {
  const auto off = [](double step) {
    Scene scene = voice(true, true);
    scene.contact.reset();
    scene.velocity.reset();
    scene.airflow->flow.rise = 1e-3;  // what swings within a step has no power that sums say
    Simulation simulation(scene, options(Newmark{}, step, 1e-12));
    double air = 0, before = 0, most = 0;
    const Airflow& airflow = *simulation.airflow();
    for (int i = 0; simulation.time() < 2e-3 - 1e-9; ++i) {
      simulation.advance();
      const FlowState& flow = simulation.record().flow->state;
      const Vector velocity =
          as_points(simulation.velocity())(airflow.nodes(), Eigen::all).reshaped<Eigen::RowMajor>();
      const AirwayExpansion moving = airflow.load_patterns().expansion(velocity);
      const double in = flow.subglottal_pressure * flow.flow_below - flow.supraglottal_pressure * flow.flow_above;
      const double tissue = in - flow.jet_power - flow.viscous_power - flow.inertial_power;
      most = std::max(most, std::abs(flow.inertial_power / tissue));
      if (simulation.time() > 7e-4) {  // before, the coupling's tolerance is all there is
        CHECK(std::abs(tissue - power_on_walls(flow, moving)) < 1e-3 * std::abs(in));
        CHECK(flow.flow_below - flow.flow_above == approx(moving.total()).epsilon(1e-3));
      }
      if (i > 0) air += 0.5 * step * (before + tissue);
      if (i == 0) air = simulation.state().ledger.flow_work;
      before = tissue;
    }
    CHECK(most > 0.01);
    return std::abs(air / simulation.state().ledger.flow_work - 1);
  };
  const double coarse = off(4e-5), fine = off(2e-5);
  CHECK(fine < 5e-3);
  CHECK(coarse / fine > 2);
}

TEST_CASE("a run that is continued goes on with the sound in its tubes and the momentum of its air, bit for bit") {
  for (const auto& [tubes, inertance] : ways)
    for (const Coupling& coupling : scenes::cases<Coupling>({Iterated{}, Extrapolated{}, Lagged{}}))
      for (const bool reduced : {false, true}) {
        Scene each = voice(tubes, inertance);
        each.airflow->coupling = coupling;
        if (reduced) each = scenes::reduced(each, scenes::every_displacement(each));
        const Simulation::Options how = options(HilberHughesTaylor{}, 1e-4, 1e-12);
        Simulation whole(each, how), second(each, how);
        for (const int after : {1, 5}) {  // the memory of a first step, and of another
          while (whole.state().step < after) whole.advance();
          State kept = whole.state();
          kept.air = AirColumn::Memory::of(kept.air.numbers());
          second.restore(kept);
          for (int i = 0; i < 3; ++i) {
            whole.advance();
            second.advance();
          }
          CHECK(second.displacement() == whole.displacement());
          CHECK(second.state().air.numbers() == whole.state().air.numbers());
          CHECK(second.state().ledger.air_inertial_energy == whole.state().ledger.air_inertial_energy);
          const auto refused = [&](const auto& damage) {
            State wrong = whole.state();
            damage(wrong);
            CHECK_THROWS_AS(second.restore(wrong), InvalidInput);
          };
          if (tubes) {
            refused([](State& wrong) { wrong.air.tract = Vector::Zero(3); });
            refused([](State& wrong) { wrong.air.trachea[1] = NAN; });
            refused([](State& wrong) { wrong.air.flow_below = INFINITY; });
          }
          if (inertance) {
            refused([](State& wrong) { wrong.air.momentum = Vector::Zero(3); });
            refused([](State& wrong) { wrong.air.momentum[1] = NAN; });
            refused([](State& wrong) { wrong.inertial_power = INFINITY; });
          }
        }
      }
}

TEST_CASE("symmetric folds between tubes are a half of the whole, with inertance too") {
  for (const bool inertance : {false, true}) {
    CAPTURE(inertance);
    Scene scene = voice(true, inertance);
    scene.velocity = scenes::symmetric_folds().velocity;
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
    if (inertance) CHECK(half.state().air.momentum[7] == approx(whole.state().air.momentum[7]).epsilon(1e-6));
  }
}

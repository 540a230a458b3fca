#include <doctest/doctest.h>

#include <algorithm>
#include <set>

#include "plica/core/error.hpp"
#include "plica/dynamics/waveforms.hpp"
#include "scenes.hpp"

using namespace plica;

namespace {

Simulation::Options coarse_steps() { return scenes::options(HilberHughesTaylor{}, 1e-4, 1e-8); }

/// The numbers of one step.
std::vector<double> step_of(const Recorder& recorder, const std::string& name, std::ptrdiff_t step) {
  const Recorder::Column& column = recorder.column(name);
  const auto from = column.values.begin() + step * column.size();
  return {from, from + column.size()};
}

}  // namespace

TEST_CASE("every waveform has a name of its own, a unit and a meaning") {
  std::set<std::string> names;
  for (const Waveform& waveform : waveforms()) {
    CAPTURE(waveform.name);
    CHECK(names.insert(waveform.name).second);
    CHECK(!waveform.unit.empty());
    CHECK(waveform.meaning.size() > 4);
    CHECK(waveform.meaning.back() == '.');
    CHECK(waveform.since_start == (waveform.meaning.find("since t = 0") != std::string::npos));
    if (waveform.whole) CHECK(waveform.unit == "1");
  }
  CHECK(names.size() > 30);
}

TEST_CASE("a scene has the waveforms of its parts and no others") {
  Scene scene = scenes::small_larynx();
  scene.contact->friction = Friction{0.3};
  scene.airflow->flow.rise = 1e-3;
  scene.airflow->tubes.trachea = Tube{{0.15}, {2e-4}, PressureSupply{}};
  scene.airflow->tubes.tract = Tube{{0.17}, {3e-4}};
  const auto had = [](const Scene& one) {
    const std::vector<std::string> names = waveforms_of(one);
    return std::set<std::string>(names.begin(), names.end());
  };
  const auto inertia = [&](bool inertance) {
    ViscousSlit slit;
    slit.inertance = inertance;
    scene.airflow->flow.model = slit;
  };
  inertia(true);
  const std::size_t linear = waveforms().size() - 2;
  CHECK(had(scene).size() == linear);
  scene.strain = FiniteStrain{};
  for (const char* name : {"nonlinear_loss", "force_evaluations"}) CHECK(had(scene).count(name) == 1);
  CHECK(had(scene).count("strain_neglected") == 0);
  scene.strain.reset();
  inertia(false);
  for (const char* name : {"air_inertial_power", "air_inertial_energy"}) CHECK(had(scene).count(name) == 0);
  CHECK(had(scene).size() == linear - 2);
  scene.airflow->flow.rise = 0;
  CHECK(had(scene).count("subglottal_pressure") == 1);
  scene.airflow->tubes.trachea.reset();
  for (const char* name : {"subglottal_pressure", "supply_rise"}) CHECK(had(scene).count(name) == 0);
  CHECK(had(scene).size() == linear - 4);
  scene.airflow->tubes.tract.reset();
  for (const char* name : {"lip_flow", "supraglottal_pressure", "flow_below", "flow_above", "tube_energy",
                           "supply_energy", "tube_outflow_energy", "tube_loss", "radiated_energy"})
    CHECK(had(scene).count(name) == 0);
  CHECK(had(scene).size() == linear - 13);
  scene.airflow->flow.rise = 1e-3;
  CHECK(had(scene).count("subglottal_pressure") == 1);
  scene.airflow->flow.rise = 0;
  scene.contact->friction.reset();
  CHECK(had(scene).count("friction_loss") == 0);
  CHECK(had(scene).size() == linear - 14);
  scene.contact.reset();
  CHECK(had(scene).count("contact_work") == 0);
  CHECK(had(scene).count("flow") == 1);
  scene.airflow.reset();
  CHECK(had(scene).count("coronal_left") == 0);
}

TEST_CASE("what is recorded is what the steps were") {
  Simulation simulation(scenes::small_larynx(), coarse_steps());
  const Indices probes = Indices::LinSpaced(2, 3, 17);
  Recorder recorder(simulation, waveforms_of(simulation.scene()), probes);
  bool touched = false;
  for (std::ptrdiff_t k = 0; k < 14; ++k) {
    simulation.advance();
    recorder.add();
    const StepRecord& record = simulation.record();
    const State& state = simulation.state();
    touched = touched || record.contact->rows > 0;
    const auto number = [&](const char* name) { return step_of(recorder, name, k).at(0); };
    CHECK(number("time") == simulation.time());
    CHECK(number("iterations") == record.iterations);
    CHECK(number("energy_balance_error") == state.ledger.error());
    CHECK(number("contact_work") == state.ledger.contact_work);
    CHECK(number("flow") == record.flow->state.flow);
    CHECK(number("coupling_converged") == record.flow->converged);
    CHECK(number("contact_rows") == record.contact->rows);
    CHECK(number("largest_contact_pressure") == record.contact->peak_pressure);
    const std::vector<double> force = step_of(recorder, "contact_force_second", k);
    CHECK(Eigen::Map<const Vector3>(force.data()) == record.contact->force_second);
    const std::vector<double> area = step_of(recorder, "section_area", k);
    CHECK(Eigen::Map<const Vector>(area.data(), simulation.airflow()->sections().count()) ==
          record.flow->state.area);
    const Points x = simulation.positions();
    const std::vector<double> left = step_of(recorder, "coronal_left", k);
    CHECK(Eigen::Map<const Vector3>(left.data() + 9) == simulation.airflow()->sections().left[3].at(x));
    const std::vector<double> moved = step_of(recorder, "probes", k);
    CHECK(Eigen::Map<const Vector3>(moved.data() + 3) == state.displacement.segment<3>(3 * 17));
  }
  REQUIRE(touched);
  const Recorder::Column& left = recorder.column("coronal_left");
  CHECK(left.steps == 14);
  CHECK(left.shape == std::vector<std::ptrdiff_t>{simulation.airflow()->sections().count(), 3});
  CHECK(left.values.size() == static_cast<std::size_t>(14 * left.size()));

  SUBCASE("what is taken is recorded no more, and what follows is") {
    const auto taken = recorder.take();
    CHECK(taken.size() == recorder.columns().size());
    CHECK(taken[0].steps == 14);
    CHECK(recorder.column("time").steps == 0);
    simulation.advance();
    recorder.add();
    CHECK(recorder.column("time").values == std::vector<double>{simulation.time()});
  }
  SUBCASE("a simulation that was restored has no last step") {
    simulation.restore(simulation.state());
    CHECK_THROWS_AS(recorder.add(), InvalidInput);
    CHECK(recorder.column("time").steps == 14);
  }
}

TEST_CASE("only what is named is recorded, and a name that is not there is refused") {
  Scene scene = scenes::small_larynx();
  scene.contact.reset();
  const Simulation simulation(scene, coarse_steps());
  Recorder recorder(simulation, {"minimum_area", "flow"});
  REQUIRE(recorder.columns().size() == 2);
  CHECK(recorder.columns()[0].waveform.name == "minimum_area");
  CHECK_THROWS_AS(recorder.add(), InvalidInput);  // no step yet
  CHECK_THROWS_AS(recorder.column("time"), InvalidInput);
  CHECK_THROWS_WITH_AS(Recorder(simulation, {"flw"}),
                       "Recorder: \"flw\" is no waveform; plica::waveforms() lists them.", InvalidInput);
  CHECK_THROWS_AS(Recorder(simulation, {"contact_work"}), InvalidInput);
  CHECK_THROWS_AS(Recorder(simulation, {"probes"}, Indices::Constant(1, 1 << 30)), InvalidInput);
}

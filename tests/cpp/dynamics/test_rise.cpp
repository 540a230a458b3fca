// A subglottal pressure that rises from 0.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "../approx.hpp"
#include "plica/core/error.hpp"
#include "plica/dynamics/waveforms.hpp"
#include "reduced_scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

constexpr double rise = 1.5e-3;  // s
const double pi = std::acos(-1.0);

/// The closed form, in the test's own words.
double risen(double p, double t) { return t < rise ? 0.5 * p * (1 - std::cos(pi * t / rise)) : p; }

Scene rising(Scene scene, const Coupling& coupling, bool slit = true) {
  if (slit) {
    scene.airflow->flow.model = ViscousSlit{};
    scene.airflow->flow.area = CutSections{20};
  }
  scene.airflow->flow.rise = rise;
  scene.airflow->coupling = coupling;
  return scene;
}

/// Largest difference of recorded pressure and flow from those of the closed form at the instants of the load.
void check_instants(const Scene& scene, const Simulation::Options& how, int steps) {
  Simulation simulation(scene, how);
  const Airflow& airflow = *simulation.airflow();
  const double p = airflow.options().subglottal_pressure, h = how.step,
               alpha = scheme_coefficients(how.scheme).alpha;
  const bool lagged = std::holds_alternative<Lagged>(scene.airflow->coupling);
  CHECK(simulation.state().flow_load.isZero(0));  // nothing presses yet
  double energy = 0, strongest = 0;
  for (int k = 0; k < steps; ++k) {
    simulation.advance();
    const double expected = risen(p, lagged ? k * h : (k + 1 + alpha) * h);
    const FlowState& flow = simulation.record().flow->state;
    CHECK(std::abs(flow.subglottal_pressure - expected) < 1e-13 * p);
    const bool held = flow.stopped || simulation.record().flow->frozen;
    const FlowState law = airflow.evaluate(flow.area, Air{expected, airflow.options().air_density}, flow.stopped,
                                           held ? std::optional(flow.separation) : std::nullopt);
    // The closed form knows 1 - cos to 1e-16 only, and the flow goes at most with the pressure.
    CHECK(std::abs(flow.flow - law.flow) <= (1e-12 + 1e-15 * p / std::max(expected, 1e-300)) * law.flow);
    CHECK((simulation.record().flow->converged || airflow.stops_at_contact()));  // Bernoulli's may jump
    const Ledger& ledger = simulation.state().ledger;
    energy = std::max(energy, ledger.kinetic + ledger.elastic);
    CHECK(std::abs(ledger.error()) < 1e-8 * energy);
    strongest = std::max(strongest, flow.subglottal_pressure);
  }
  CHECK(strongest == p);  // the rise has ended
}

}  // namespace

TEST_CASE("the pressure rises from 0 as half a cosine, with a slope that is continuous") {
  Scene scene = scenes::small_larynx();
  const auto air = [&](double length, double time) {
    scene.airflow->flow.rise = length;
    return Airflow(scene.mesh, scene.mesh.surface("airway"), scene.airflow->flow).air(time);
  };
  CHECK(air(0, 0).subglottal_pressure == 800);  // suddenly, as without
  CHECK(air(rise, 0).subglottal_pressure == 0);
  CHECK(air(rise, -0.3 * rise).subglottal_pressure == 0);  // not the mirror image of the rise
  CHECK(air(rise, rise).subglottal_pressure == 800);
  CHECK(air(rise, 10 * rise).subglottal_pressure == 800);
  CHECK(air(rise, 0.3 * rise).density == scene.airflow->flow.air_density);
  for (const double t : {1e-6, 0.2 * rise, 0.5 * rise, 0.999 * rise})
    CHECK(air(rise, t).subglottal_pressure == approx(risen(800, t)).epsilon(1e-9));
  const double h = 1e-4 * rise;  // its second derivative is at most p pi^2 / (2 rise^2)
  const double small = 800 * std::pow(pi, 2) / (2 * rise * rise) * h;
  CHECK(air(rise, h).subglottal_pressure / h < small);
  CHECK((800 - air(rise, rise - h).subglottal_pressure) / h < small);
  for (const double bad : {-1e-3, std::nan(""), HUGE_VAL}) {
    scene.airflow->flow.rise = bad;
    CHECK_THROWS_WITH_AS(scene.airflow->flow.validate(), doctest::Contains("rise"), InvalidInput);
  }
}

TEST_CASE("a course is straight lines between its points, and held beyond them") {
  Scene scene = scenes::small_larynx();
  Airflow::Options& flow = scene.airflow->flow;
  flow.course = PressureCourse{{1e-3, 2e-3, 4e-3}, {800, 200, 500}};
  const Airflow airflow(scene.mesh, scene.mesh.surface("airway"), flow);
  const auto at = [&](double time) { return airflow.air(time).subglottal_pressure; };
  for (const double t : {-1e-3, 0.0, 1e-3}) CHECK(at(t) == 800);
  CHECK(at(1.25e-3) == approx(650));
  CHECK(at(2e-3) == 200);
  CHECK(at(3e-3) == approx(350));
  for (const double t : {4e-3, 1.0}) CHECK(at(t) == 500);
  CHECK(airflow.air(2e-3).density == flow.air_density);
  flow.rise = 2.5e-3;
  const Airflow rising(scene.mesh, scene.mesh.surface("airway"), flow);
  for (const double t : {-1e-3, 0.0, 0.4e-3, 1.25e-3, 2.4e-3, 2.5e-3, 3e-3, 1.0}) {
    const double share = 0.5 - 0.5 * std::cos(pi * std::clamp(t / flow.rise, 0.0, 1.0));
    CHECK(rising.air(t).subglottal_pressure == approx(share * at(t)).epsilon(1e-9));
  }
}

TEST_CASE("a course that is none is refused by what is wrong with it") {
  Airflow::Options flow;
  const auto refused = [&](const PressureCourse& course, const char* text) {
    flow.course = course;
    CHECK_THROWS_WITH_AS(flow.validate(), doctest::Contains(text), InvalidInput);
  };
  refused({{0.0}, {800}}, "number of times = 1; must be >= 2");
  refused({{0, 1}, {800}}, "number of pressures = 1; must be that of times, 2");
  refused({{-1, 1}, {800, 0}}, "time[0] = -1 s; must be >= 0");
  refused({{1, 1}, {800, 0}}, "time[1] = 1 s; must be > the one before, 1 s");
  refused({{0, std::nan("")}, {800, 0}}, "time[1]");
  refused({{0, 1}, {800, -1}}, "pressure[1] = -1 Pa; must be >= 0");
  refused({{0, 1}, {0, 0}}, "greatest pressure = 0 Pa; must be > 0");
  refused({{0, 1}, {500, 300}}, "subglottal_pressure = 800 Pa; must be the greatest of the course, 500 Pa");
}

TEST_CASE("the flow is that of the pressure at the instant at which the load acts, however a step is taken") {
  const HilberHughesTaylor hht;
  for (const Coupling& coupling : {Coupling(Iterated{}), Coupling(Extrapolated{}), Coupling(Lagged{})})
    for (const bool slit : {true, false}) {
      const Scene scene = rising(scenes::small_larynx(), coupling, slit);
      check_instants(scene, options(hht, 1e-4), 20);
      if (!slit) continue;
      const Scene folds = rising(scenes::symmetric_folds(), coupling);
      check_instants(scenes::reduced(folds, scenes::every_displacement(folds)), options(hht, 1e-4), 20);
      Scene symmetric = folds;
      symmetric.symmetry = Symmetry::half;
      check_instants(symmetric, options(hht, 1e-4), 20);
    }
}

TEST_CASE("explicit steps have the pressure of their own instants, too") {
  for (const Coupling& coupling : {Coupling(Extrapolated{}), Coupling(Lagged{})}) {
    Scene scene = rising(scenes::small_larynx(), coupling);
    scene.contact.reset();
    Simulation::Options how = options(CentralDifferences{}, 4e-7);
    how.mass = Simulation::Mass::lumped;
    check_instants(scene, how, 3800);
  }
}

TEST_CASE("between walls that hardly move the flow of air without friction goes with the root of the pressure") {
  Scene scene = rising(scenes::small_larynx(), Iterated{});
  scene.airflow->flow.model = ViscousSlit{1.2, 0.0, 3e-4};
  scene.tissue.materials[0].elasticity = Isotropic{1e12, 0.3};
  scene.velocity.reset();
  Simulation simulation(scene, options(HilberHughesTaylor{}, 1e-4));
  const double full = simulation.airflow()->evaluate(simulation.airflow()->areas(scene.mesh.points)).flow;
  REQUIRE(full > 1e-5);
  for (int k = 0; k < 20; ++k) {
    simulation.advance();
    const double share = risen(1, (k + 0.7) * 1e-4);
    // The walls give way by less than a strain of 1e-8.
    CHECK(simulation.record().flow->state.flow == approx(full * std::sqrt(share)).epsilon(1e-6));
  }
}

TEST_CASE(
    "what is set in motion by a rising pressure converges with the square of the step; lagged, with the step") {
  const auto end = [](const Coupling& coupling, int steps) {
    Scene scene = rising(scenes::small_larynx(), coupling);
    scene.contact.reset();
    scene.velocity.reset();
    Simulation simulation(scene, options(HilberHughesTaylor{}, 1.2e-3 / steps));
    for (int k = 0; k < steps; ++k) simulation.advance();
    return Vector(simulation.state().displacement);
  };
  const auto order = [&](const Coupling& coupling) {
    const Vector coarse = end(coupling, 40), middle = end(coupling, 80), fine = end(coupling, 160);
    REQUIRE(fine.norm() > 1e-5);
    return std::log2((coarse - middle).norm() / (middle - fine).norm());
  };
  CHECK(order(Iterated{1e-10}) == approx(2).epsilon(0.1));
  CHECK(order(Extrapolated{}) == approx(2).epsilon(0.1));
  CHECK(order(Lagged{}) == approx(1).epsilon(0.1));
}

TEST_CASE("only a scene whose pressure rises has a waveform of it") {
  const auto has = [](const Scene& scene) {
    const std::vector<std::string> names = waveforms_of(scene);
    return std::find(names.begin(), names.end(), "subglottal_pressure") != names.end();
  };
  Scene scene = scenes::small_larynx();
  CHECK(!has(scene));
  scene.airflow->flow.rise = rise;
  CHECK(has(scene));
}

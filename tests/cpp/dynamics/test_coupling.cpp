// The iterated coupling where it cannot agree: what is held, what is kept, and that the equations hold all the
// same.
#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "../approx.hpp"
#include "plica/core/error.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

Scene larynx_with(const Coupling& coupling) {
  Scene scene = scenes::small_larynx();
  scene.airflow->coupling = coupling;
  return scene;
}

/// Soft folds under high pressure: within ten steps of 0.1 ms a sweep's pressures move the least section.
Scene soft_larynx_with(const Coupling& coupling) {
  Scene scene = larynx_with(coupling);
  scene.airflow->flow.subglottal_pressure = 2500;
  scene.tissue.materials[0].elasticity = Isotropic{7e3, 0.45};
  return scene;
}

/// |M a + C V + K U - f - f_c| on the free unknowns, of the size of f.
double equilibrium_error(const Simulation& simulation) {
  const State& s = simulation.state();
  Vector off = s.inertial_force + s.viscous_force + s.weighted_elastic_force - s.load - s.contact_force;
  simulation.scene().supports.project(off);
  return off.norm() / s.load.norm();
}

double surface_area(const TetMesh& mesh, const std::string& name) {
  double sum = 0;
  for (const auto& face : mesh.surface(name).rowwise()) {
    const Vector3 a = mesh.points.row(face[0]), b = mesh.points.row(face[1]), c = mesh.points.row(face[2]);
    sum += 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

/// What the flow does at the weighted positions of the step from `before` to the simulation's state.
FlowState flow_after(const Simulation& simulation, const Points& before) {
  constexpr double alpha = -0.3;
  const Airflow& airflow = *simulation.airflow();
  return airflow.evaluate(airflow.areas((1 + alpha) * simulation.positions() - alpha * before),
                          simulation.state().air.flow_stopped);
}

}  // namespace

TEST_CASE("from sweep freeze_after on, separation and stop are those that this sweep found") {
  const auto soft = [](const Coupling& coupling) { return soft_larynx_with(coupling); };
  const auto opening = [](const Coupling& coupling) {
    Scene scene = larynx_with(coupling);
    scene.airflow->flow.subglottal_pressure = 2000;
    *scene.velocity *= -1;
    return scene;
  };
  int frozen = 0, section_held = 0, stop_held = 0;
  const auto compare = [&](const auto& scene, double step, int steps) {
    const Simulation::Options o = options(HilberHughesTaylor{}, step, 1e-10);
    Simulation iterated(scene(Iterated{1e-5, 2, 1}), o);
    Simulation first_sweep(scene(Extrapolated{}), o);  // its one sweep is the first of the iterated coupling
    for (int k = 0; k < steps; ++k) {
      const Points before = iterated.positions();
      first_sweep.restore(iterated.state());
      iterated.advance();
      const FlowRecord& flow = *iterated.record().flow;
      CHECK(flow.frozen == (flow.sweeps > 1));
      if (!flow.frozen) continue;
      ++frozen;
      first_sweep.advance();
      const FlowState held = flow_after(first_sweep, before);
      CHECK(flow.state.separation == held.separation);
      CHECK(flow.state.stopped == held.stopped);
      CHECK(iterated.state().air.flow_stopped == first_sweep.state().air.flow_stopped);
      const FlowState by_areas = iterated.airflow()->evaluate(flow.state.area, held.stopped);
      section_held += by_areas.separation != held.separation;
      stop_held += held.stopped && flow.state.area.minCoeff() > 0 && iterated.record().contact->rows == 0;
    }
  };
  compare(soft, 1e-4, 40);
  compare(opening, 2e-4, 12);
  CHECK(frozen > 20);
  CHECK(section_held > 0);  // the areas of the second sweep alone would have given another
  CHECK(stop_held > 0);     // nothing touches any more
}

TEST_CASE("a step that switches from sweep to sweep converges once its separation is held") {
  Simulation simulation(soft_larynx_with(Iterated{}), options(HilberHughesTaylor{}, 1e-4, 1e-10));
  int frozen = 0;
  for (int k = 0; k < 10; ++k) {
    simulation.advance();
    const FlowRecord& flow = *simulation.record().flow;
    CHECK(flow.converged);
    CHECK(flow.residual <= Iterated{}.tolerance);
    CHECK(flow.frozen == (flow.sweeps > Iterated{}.freeze_after));
    CHECK(equilibrium_error(simulation) < 1e-8);
    frozen += flow.frozen;
  }
  CHECK(frozen > 0);
}

TEST_CASE(
    "a coupling that does not converge is data: equilibrium holds under a load that is off by the residual") {
  const Iterated coupling{1e-5, 2, 1};
  const Scene scene = larynx_with(coupling);
  const double pressure = scene.airflow->flow.subglottal_pressure, area = surface_area(scene.mesh, "airway");
  Simulation simulation(scene, options(HilberHughesTaylor{}, 5e-5, 1e-10));
  int unconverged = 0;
  double energy = 0;
  for (int k = 0; k < 60; ++k) {
    simulation.advance();
    const FlowRecord& flow = *simulation.record().flow;
    const State& s = simulation.state();
    CHECK(equilibrium_error(simulation) < 1e-8);
    CHECK(flow.converged == (flow.residual <= coupling.tolerance));
    // The sum over nodes of |int N_l dp n dA| is at most the largest dp times the area; the load is that of one
    // sweep earlier, on the reference surface.
    Vector of_state = Vector::Zero(s.load.size());
    simulation.airflow()->add_load(scene.mesh.points, flow.state.on_walls(), of_state);
    const double off = as_points(Vector(of_state - s.load)).rowwise().norm().sum();
    CHECK(off <= flow.residual * pressure * area + 1e-14 * s.load.lpNorm<1>());
    energy = std::max(energy, s.ledger.kinetic + s.ledger.elastic);
    CHECK(std::abs(s.ledger.error()) < 1e-8 * energy);
    if (flow.converged) continue;
    ++unconverged;
    CHECK(flow.sweeps == coupling.max_sweeps);
    CHECK(flow.frozen);
    CHECK(off > 1e-3 * flow.residual * pressure * area);
  }
  CHECK(unconverged > 5);
}

TEST_CASE(
    "fewer sweeps than freeze_after are refused where there is something to freeze, and no hindrance elsewhere") {
  Scene scene = larynx_with(Iterated{1e-5, 8, 8});
  const Simulation::Options o = options(HilberHughesTaylor{}, 5e-5, 1e-10);
  CHECK_THROWS_WITH_AS(
      Simulation(scene, o),
      doctest::Contains("Iterated: max_sweeps = 8; must be > freeze_after = 8 with Bernoulli's flow."),
      InvalidInput);
  scene.airflow->flow.model = ViscousSlit{};
  scene.airflow->coupling = Iterated{1e-15, 2, 8};  // does not converge, and ends after two
  Simulation few(scene, o);
  few.advance();
  CHECK(few.record().flow->sweeps == 2);
  CHECK_FALSE(few.record().flow->frozen);
  // That option makes no other difference: to the bit.
  scene.airflow->coupling = Iterated{1e-15, 2, 1};
  Simulation same(scene, o);
  same.advance();
  CHECK(few.state().displacement == same.state().displacement);
}

TEST_CASE("a coupling that does not iterate has one load in all rounds of tissue at finite strain") {
  constexpr double alpha = -0.3, step = 5e-5;
  for (const Coupling& coupling : {Coupling{Lagged{}}, Coupling{Extrapolated{}}})
    for (const bool current : {false, true}) {
      Scene scene = larynx_with(coupling);
      scene.airflow->flow.model = ViscousSlit{};
      if (current) scene.airflow->flow.load_shape = Airflow::CurrentShape{};
      scene.strain = FiniteStrain{1e-9, 400};
      Simulation simulation(scene, options(HilberHughesTaylor{alpha}, step, 1e-12));
      const Airflow& airflow = *simulation.airflow();
      int most_rounds = 0, most_rows = 0;
      for (int k = 0; k < 20; ++k) {
        const Points before = simulation.positions();
        const State& s = simulation.state();
        Points x = before;  // of the load
        if (std::holds_alternative<Extrapolated>(coupling))
          x += (1 + alpha) * step * as_points(Vector(s.velocity + 0.5 * step * s.acceleration));
        simulation.advance();
        const FlowRecord& flow = *simulation.record().flow;
        most_rounds = std::max(most_rounds, simulation.record().force_evaluations);
        most_rows = std::max(most_rows, simulation.record().contact->rows);
        CHECK(flow.sweeps == 1);
        const FlowState taken = airflow.evaluate(airflow.areas(x));
        CHECK((flow.state.pressure - taken.pressure).norm() <= 1e-12 * taken.pressure.norm());
        Vector load = Vector::Zero(s.load.size());
        airflow.add_load(x, taken.on_walls(), load);
        CHECK((s.load - load).norm() <= 1e-12 * load.norm());
        const Vector reached =
            airflow.evaluate(airflow.areas((1 + alpha) * simulation.positions() - alpha * before)).pressure;
        CHECK(flow.residual == approx(pressure_difference(airflow, reached, taken.pressure)).epsilon(1e-9));
        Vector off = s.inertial_force + s.viscous_force + s.weighted_elastic_force + s.elastic_excess +
                     s.viscous_excess - s.load - s.contact_force;
        scene.supports.project(off);
        CHECK(off.norm() < 1e-7 * s.load.norm());
        CHECK(std::abs(s.ledger.error()) < 1e-7 * s.ledger.kinetic);
      }
      CHECK(most_rounds > 2);
      CHECK(most_rows > 0);
    }
}

TEST_CASE(
    "what a round of a step has held of Bernoulli's flow is held in the rounds after it, and after many rounds") {
  /// Its areas do not answer to pressures.
  class StillStep final : public CoupledStep {
   public:
    Vector areas(Instant) const override { return now; }
    AirwayExpansion expansion(Instant) const override { return {}; }
    void move(const AirwayPressure&, Instant) override {}
    bool blocks() const override { return touches; }
    StepTimes& times() const override { return times_; }
    Vector now;
    bool touches = false;

   private:
    mutable StepTimes times_;
  };
  const Simulation simulation(larynx_with(Iterated{}), options(HilberHughesTaylor{}, 1e-4, 1e-10));
  const Airflow& airflow = *simulation.airflow();
  AirColumn column(airflow, 1e-4);
  column.begin_step({}, 0.0, 1e-4);
  StillStep step;
  step.now = Vector::Constant(airflow.sections().count(), 2e-5);
  step.now[5] = 1e-5;
  std::optional<FlowRecord> flow;
  couple(Iterated{}, column, step, flow);
  REQUIRE(flow->state.separation == 5);
  CHECK_FALSE(flow->frozen);

  step.now[5] = 2e-5;
  step.now[3] = 1e-5;
  step.touches = true;
  const auto after = [&](bool frozen, int sweeps) {
    std::optional<FlowRecord> round = flow;
    round->frozen = frozen;
    round->sweeps = sweeps;
    couple(Iterated{}, column, step, round);
    CHECK(round->sweeps > sweeps);
    return *round;
  };
  CHECK(after(false, 1).state.stopped);
  for (const auto& [frozen, sweeps] : {std::pair{true, 9}, std::pair{false, 10 * Iterated{}.freeze_after}}) {
    const FlowRecord held = after(frozen, sweeps);
    CHECK(held.frozen);
    CHECK(held.state.separation == 5);
    CHECK_FALSE(held.state.stopped);
  }
}

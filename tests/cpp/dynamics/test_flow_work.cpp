// What the airflow does, in the energy ledger.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "../approx.hpp"
#include "plica/core/error.hpp"
#include "plica/dynamics/ledger.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

const TimeScheme every_scheme[] = {Newmark{}, HilberHughesTaylor{-0.1}, HilberHughesTaylor{-1.0 / 3},
                                   Newmark{1.0, 1.5}};

/// Where the load of a step to t = 1 lies on the way from that of the step before, 0, to its own: the middle of
/// the step, as loads are those of t_{n+1+alpha}, but for the one of t = 0.
double middle(const TimeScheme& scheme, bool first) {
  const auto* hht = std::get_if<HilberHughesTaylor>(&scheme);
  const double alpha = hht ? hht->alpha : 0.0;
  return first ? 0.5 / (1 + alpha) : 0.5 - alpha;
}

/// Work of nodal pressures (Pa, at the airflow's nodes) on the wall at rest through displacements du (3 n): the
/// rule of the three mid-sides, exact for linear times linear on flat triangles.
double work(const Airflow& airflow, const TetMesh& mesh, const Vector& nodal, const Vector& du) {
  Vector pressure = Vector::Zero(mesh.node_count());
  for (std::ptrdiff_t i = 0; i < nodal.size(); ++i) pressure[airflow.nodes()[i]] = nodal[i];
  double sum = 0;
  for (const auto& face : mesh.surface("airway").rowwise()) {
    const Vector3 a = mesh.points.row(face[0]), b = mesh.points.row(face[1]), c = mesh.points.row(face[2]);
    const Vector3 area = 0.5 * (b - a).cross(c - a);  // into the air
    for (int k = 0; k < 3; ++k) {
      const std::ptrdiff_t i = face[k], j = face[(k + 1) % 3];
      const Vector3 moved = 0.5 * (du.segment<3>(3 * i) + du.segment<3>(3 * j));
      sum -= 0.5 * (pressure[i] + pressure[j]) * moved.dot(area) / 3;
    }
  }
  return sum;
}

/// A block as it is at rest, a pressure on all its faces for the airflow's load.
struct Bubble {
  Scene scene = scenes::held_block();
  Assembler assembler{scene.mesh};
  Motion motion;
  State rest;
  Vector unit;  // N a Pa

  explicit Bubble(const TimeScheme& scheme) : motion(scene, nullptr, assembler, options(scheme, 1e-4)) {
    rest = Simulation(scene, options(scheme, 1e-4)).state();
    motion.begin(rest);
    unit = Vector::Zero(3 * scene.mesh.node_count());
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {-1.0, 1.0})
        unit += assembler.traction(scene.mesh.surface(std::string(1, "xyz"[axis]) + (side < 0 ? "_min" : "_max")),
                                   -side * Vector3::Unit(axis));
  }
};

}  // namespace

TEST_CASE("the work of the air on a wall that moves or swells is its pressure times the volume it gains") {
  for (const TimeScheme& scheme : every_scheme)
    for (const bool first : {true, false}) {
      const Bubble bubble(scheme);
      const Points& X = bubble.scene.mesh.points;
      const double p0 = 700, p1 = 500, m = middle(scheme, first), mean = p0 + m * (p1 - p0);
      State before = bubble.rest;
      before.step = first ? 0 : 5;
      before.flow_load = p0 * bubble.unit;
      State now = before;
      ++now.step;
      const auto done = [&](const Points& displacement, const Vector& unit) {
        before.flow_load = p0 * unit;
        now.flow_load = p1 * unit;
        now.displacement = as_vector(displacement);
        return continued_ledger(bubble.motion, before, now).flow_work;
      };
      // It swells: air around it loses the volume that it gains.
      Points swelling = X;
      swelling.col(0) *= 0.01;
      swelling.col(1) *= 0.02;
      swelling.col(2) *= -0.005;
      const double volume = 0.02 * 0.01 * 0.01;
      CHECK(done(swelling, bubble.unit) == approx(-mean * volume * 0.025).epsilon(1e-12));
      // It moves as a whole: nothing; its face alone, under pressure there: an area times a way.
      const Points moving = Points::Constant(X.rows(), 3, 1e-3);
      CHECK(std::abs(done(moving, bubble.unit)) < 1e-14 * mean * volume);
      const Vector face = bubble.assembler.traction(bubble.scene.mesh.surface("x_max"), -Vector3::UnitX());
      CHECK(done(-moving, face) == approx(mean * 1e-4 * 1e-3).epsilon(1e-12));
    }
}

TEST_CASE("energy that the air is supplied with and loses is exact where its powers are linear in time") {
  for (const TimeScheme& scheme : every_scheme) {
    const auto* hht = std::get_if<HilberHughesTaylor>(&scheme);
    const double alpha = hht ? hht->alpha : 0.0, h = 1e-4, a = 0.3, b = 40, share = 0.25;
    const Bubble bubble(scheme);
    State now = bubble.rest;
    now.flow_load = bubble.unit;
    const int steps = 7;
    for (int k = 0; k <= steps; ++k) {
      const State before = now;
      now.step = k;
      now.supplied_power = a + b * (k == 0 ? 0 : (k + alpha) * h);
      now.viscous_power = share * now.supplied_power;
      if (k > 0) now.ledger = continued_ledger(bubble.motion, before, now);
    }
    const double exact = a * steps * h + b * steps * h * steps * h / 2;
    CHECK(now.ledger.air_supplied_energy == approx(exact).epsilon(1e-12));
    CHECK(now.ledger.air_viscous_energy == approx(share * exact).epsilon(1e-12));
    CHECK(now.ledger.flow_work == 0.0);  // nothing has moved
  }
}

TEST_CASE(
    "in a larynx the airflow's work is that of its pressures on the wall, and the rest is the other loads'") {
  for (const bool slit : {false, true})
    for (const TimeScheme& scheme : every_scheme) {
      Scene scene = scenes::small_larynx();
      if (slit) scene.airflow->flow.model = ViscousSlit{};
      if (slit) scene.airflow->flow.rise = 1.5e-3;
      scene.airflow->coupling = Extrapolated{};  // whose pressures on record are those of the load
      scene.gravity = Vector3(30, -20, -50);
      Simulation simulation(scene, options(scheme, 1e-4));
      const Airflow& airflow = *simulation.airflow();
      const TetMesh& mesh = simulation.scene().mesh;
      const FlowState start = airflow.evaluate(airflow.areas(mesh.points), airflow.air(0));
      Vector pressure = airflow.nodal_pressure({start.subglottal_pressure, start.pressure});
      double supplied = start.supplied_power, lost = start.viscous_power;
      double done = 0, largest = 0, energy = 0, loss = 0;
      for (int k = 0; k < 20; ++k) {
        const Vector u = simulation.state().displacement;
        simulation.advance();
        const FlowState& flow = simulation.record().flow->state;
        const double m = middle(scheme, k == 0), h = 1e-4;
        const Vector p = airflow.nodal_pressure({flow.subglottal_pressure, flow.pressure});
        done += work(airflow, mesh, pressure + m * (p - pressure), simulation.state().displacement - u);
        largest = std::max(largest, std::abs(done));
        energy += h * (supplied + m * (flow.supplied_power - supplied));
        loss += h * (lost + m * (flow.viscous_power - lost));
        pressure = p;
        supplied = flow.supplied_power;
        lost = flow.viscous_power;
      }
      const Ledger& ledger = simulation.state().ledger;
      const Assembler assembler(mesh);
      const Vector weight = assembler.body_force(scene.tissue, *scene.gravity);
      const double fallen = weight.dot(simulation.state().displacement);  // held nodes stay where they are
      REQUIRE(std::abs(fallen) > 1e-3 * largest);
      CHECK(std::abs(ledger.flow_work - done) < 1e-12 * largest);
      CHECK(std::abs(ledger.load_work - ledger.flow_work - fallen) < 1e-12 * (largest + std::abs(fallen)));
      CHECK(ledger.air_supplied_energy == approx(energy).epsilon(1e-12));
      CHECK(ledger.air_supplied_energy > 0);
      CHECK(ledger.air_viscous_energy == approx(loss).epsilon(1e-12));
      CHECK((ledger.air_viscous_energy > 0) == slit);
      CHECK(ledger.air_viscous_energy < ledger.air_supplied_energy);
    }
}

TEST_CASE("without airflow none of its terms is there") {
  Scene scene = scenes::held_block();
  scene.gravity = Vector3(0, 0, -9.81);
  Simulation simulation(scene, options(HilberHughesTaylor{}, 1e-4));
  simulation.advance();
  const State& state = simulation.state();
  CHECK(state.flow_load.size() == 0);
  CHECK(state.ledger.load_work != 0);
  CHECK(state.ledger.flow_work == 0);
  CHECK(state.ledger.air_supplied_energy == 0);
  State other = state;
  other.flow_load = Vector::Zero(state.load.size());
  CHECK_THROWS_WITH_AS(simulation.restore(other), doctest::Contains("flow_load"), InvalidInput);
}

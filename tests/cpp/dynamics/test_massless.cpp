// Contact surfaces without mass.
#include <doctest/doctest.h>

#include <algorithm>

#include "../approx.hpp"
#include "plica/core/error.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

const TimeScheme schemes[] = {Newmark{}, HilberHughesTaylor{-0.1}, HilberHughesTaylor{-0.3},
                              HilberHughesTaylor{-1.0 / 3}, Newmark{1.0, 1.5}};

Scene massless(Scene scene) {
  scene.contact->surface_mass = SurfaceMass::redistributed;
  return scene;
}

/// R1 over four periods: energies over that at the start, and the largest force, exactly 1/2.
struct Bounces {
  double energy_first = 0, energy_most = 0, energy_end = 0, force = 0;
};
Bounces bounces(const Scene& scene, int n, const TimeScheme& scheme) {
  Simulation simulation(scene, options(scheme, 0.5 / n, 1e-10));
  Bounces result;
  while (simulation.time() < 12.0) {
    simulation.advance();
    const Ledger& ledger = simulation.state().ledger;
    result.energy_end = (ledger.kinetic + ledger.elastic) / ledger.initial;
    if (simulation.state().step == 1) result.energy_first = result.energy_end;
    result.energy_most = std::max(result.energy_most, result.energy_end);
    result.force = std::max(result.force, simulation.record().contact->force_first.norm() * n * n);
  }
  return result;
}

}  // namespace

TEST_CASE("without mass on the surface the trapezoidal rule bounces a bar without making energy") {
  const int n = 30;
  const Scene bar = scenes::periodic_bar(n, Multipliers{});
  const Bounces kept = bounces(bar, n, Newmark{}), moved = bounces(massless(bar), n, Newmark{});
  CHECK(kept.energy_end > 2);  // chaotic; 35
  CHECK(kept.force > 4);
  // The strained first row, 1/n of all the energy, has a free end: it springs back in the first step.
  CHECK(moved.energy_first == approx(1 - 1.0 / n).epsilon(2e-3));
  // A step that opens a gap gains what p g is at its ends, one that closes it loses as much: 6e-4 of the energy
  // here.
  CHECK(moved.energy_most < (1 + 1e-3) * moved.energy_first);
  CHECK(moved.energy_end > 0.995 * moved.energy_first);
  CHECK(moved.force < 0.87);
}

TEST_CASE("the ledger closes where the surfaces have no mass") {
  for (const TimeScheme& scheme : schemes)
    for (const Enforcement& enforcement :
         {Enforcement(Multipliers{}), Enforcement(Augmented{}), Enforcement(Nitsche{}), Enforcement(Penalty{50.0}),
          Enforcement(VolumePenalty{1e9})})
      for (const Simulation::Mass mass : {Simulation::Mass::consistent, Simulation::Mass::lumped}) {
        Scene scene = massless(scenes::two_cubes(enforcement, 0.5, 4));
        // One load bends the surfaces of contact, which are not in balance at t = 0.
        scene.loads = {{"a.y_max", {0, -40, 10}, 80.0, 0.4}, {"b.x_min", {50, 0, 200}, 0.0, 0.0}};
        scene.gravity = Vector3(0, 0, -9.81);
        Simulation::Options with = options(scheme, 1e-4);
        with.mass = mass;
        Simulation simulation(scene, with);
        double largest = 0, off = 0, first = 0;
        for (int k = 0; k < 60; ++k) {
          simulation.advance();
          const Ledger& ledger = simulation.state().ledger;
          if (k == 0) first = ledger.numerical_loss;
          largest = std::max(largest, ledger.kinetic + ledger.elastic);
          off = std::max(off, std::abs(ledger.error()));
        }
        const Ledger& ledger = simulation.state().ledger;
        CHECK(std::abs(ledger.load_work) > 1e-4 * largest);
        CHECK(std::abs(ledger.contact_work) > 1e-4 * largest);
        CHECK(std::abs(first) > 1e-6 * largest);
        if (std::holds_alternative<Newmark>(scheme) && std::get<Newmark>(scheme).gamma == 0.5)
          CHECK(std::abs(ledger.numerical_loss - first) < 1e-12 * largest);
        CHECK(off <= 1e-12 * largest);
      }
}

TEST_CASE("free bodies without mass on their surfaces keep their momentum through contact") {
  for (const TimeScheme& scheme : schemes) {
    Scene scene = massless(scenes::two_cubes(Multipliers{}, 0.5, 4));
    scene.supports = Supports(scene.mesh.node_count());
    Simulation simulation(scene, options(scheme, 1e-4));
    const auto momentum = [&] {
      const Vector p = simulation.mass() * simulation.state().velocity;
      return Vector3(as_points(p).colwise().sum().transpose());
    };
    const Vector3 before = momentum();
    const double each = 1040 * 1e-6;  // kg
    CHECK((before - each * Vector3(0, 0.3, -0.2)).norm() < 1e-13 * each);
    bool touched = false;
    for (int k = 0; k < 60; ++k) {
      simulation.advance();
      touched = touched || simulation.record().contact->rows > 0;
      CHECK((momentum() - before).norm() < 1e-11 * each);
    }
    CHECK(touched);
  }
}

TEST_CASE("a surface without mass has no acceleration at the start, whatever pulls at it") {
  Scene scene = massless(scenes::two_cubes(Multipliers{}, 0.0, 4));
  scene.loads = {{"b.x_min", {500, 0, 2000}, 0.0, 0.0}, {"b.y_max", {0, 100, 0}, 0.0, 0.0}};
  const Simulation simulation(scene, options(Newmark{}, 1e-4));
  const Vector& a = simulation.state().acceleration;
  for (const auto node : scene.mesh.node_set("b.x_min"))
    CHECK(a.segment<3>(3 * static_cast<std::ptrdiff_t>(node)).isZero(0));
  CHECK(a.cwiseAbs().maxCoeff() > 1);
  // Elsewhere the equation of motion holds.
  Vector left = simulation.state().inertial_force - simulation.state().load;
  for (const auto node : scene.mesh.node_set("b.x_min")) left.segment<3>(3 * node).setZero();
  scene.supports.project(left);
  CHECK(left.norm() < 1e-12 * simulation.state().load.norm());
}

TEST_CASE("held nodes keep their mass") {
  const Scene bar = scenes::periodic_bar(10, Multipliers{});
  const Simulation kept(bar, options(Newmark{}, 0.05)), moved(massless(bar), options(Newmark{}, 0.05));
  const NodePattern& pattern = *moved.mass().pattern();
  for (std::int32_t i = 0; i < 8; ++i)  // the obstacle
    for (std::int32_t j = 0; j < 8; ++j)
      if (const auto at = pattern.find(i, j); at >= 0)
        CHECK(moved.mass().values()[static_cast<std::size_t>(at)] ==
              kept.mass().values()[static_cast<std::size_t>(at)]);
  for (const auto node : bar.mesh.node_set("b.x_min"))
    CHECK(moved.mass().values()[static_cast<std::size_t>(pattern.find(node, node))] == 0);
}

TEST_CASE(
    "a larynx whose folds have no mass on their surfaces collides, continues from a state, and keeps its ledger") {
  const Simulation::Options o = options(HilberHughesTaylor{}, 1e-4, 1e-10);
  Simulation whole(massless(scenes::small_larynx()), o), second(massless(scenes::small_larynx()), o);
  second.restore(whole.state());
  bool touched = false;
  double largest = 0, off = 0;
  for (int k = 0; k < 24; ++k) {
    whole.advance();
    second.advance();
    touched = touched || whole.record().contact->rows > 0;
    const Ledger& ledger = whole.state().ledger;
    largest = std::max(largest, ledger.kinetic + ledger.elastic);
    off = std::max(off, std::abs(ledger.error()));
  }
  CHECK(touched);
  CHECK(off < 1e-9 * largest);
  CHECK(whole.state().displacement == second.state().displacement);
  CHECK(whole.state().ledger.numerical_loss == second.state().ledger.numerical_loss);
}

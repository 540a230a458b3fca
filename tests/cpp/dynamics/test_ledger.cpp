#include <doctest/doctest.h>

#include <algorithm>

#include "../approx.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;

TEST_CASE("the energy ledger closes with load, viscosity, gravity and contact") {
  for (const TimeScheme& scheme :
       {TimeScheme(Newmark{}), TimeScheme(HilberHughesTaylor{-0.1}), TimeScheme(HilberHughesTaylor{-0.3}),
        TimeScheme(HilberHughesTaylor{-1.0 / 3}), TimeScheme(Newmark{1.0, 1.5})})
    for (const Enforcement& enforcement :
         {Enforcement(Multipliers{}), Enforcement(Penalty{50.0}), Enforcement(VolumePenalty{1e9})}) {
      Scene scene = scenes::two_cubes(enforcement);
      scene.loads = {{"a.y_max", {0, -40, 10}, 80.0, 0.4}, {"b.z_min", {5, 0, 20}, 0.0, 0.0}};
      scene.gravity = Vector3(0, 0, -9.81);
      Simulation simulation(scene, options(scheme, 1e-4));
      double largest = 0, off = 0;
      for (int k = 0; k < 60; ++k) {
        simulation.advance();
        const Ledger& ledger = simulation.state().ledger;
        largest = std::max(largest, ledger.kinetic + ledger.elastic);
        off = std::max(off, std::abs(ledger.error()));
      }
      const Ledger& ledger = simulation.state().ledger;
      CHECK(std::abs(ledger.load_work) > 1e-4 * largest);
      CHECK(std::abs(ledger.contact_work) > 1e-4 * largest);
      CHECK(ledger.viscous_loss > 1e-2 * largest);
      if (!std::holds_alternative<Newmark>(scheme) || std::get<Newmark>(scheme).gamma > 0.5)
        CHECK(ledger.numerical_loss > 1e-5 * largest);
      else
        CHECK(std::abs(ledger.numerical_loss) < 1e-13 * largest);  // the trapezoidal rule loses nothing
      CHECK(off <= 1e-12 * largest);                               // 60 steps solved at 1e-13
    }
}

TEST_CASE("momentum of bodies without supports is conserved through contact") {
  Scene scene = scenes::two_cubes(Multipliers{});
  scene.supports = Supports(scene.mesh.node_count());
  Simulation simulation(scene, options(HilberHughesTaylor{}, 1e-4));
  const auto momentum = [&] {
    const Vector p = simulation.mass() * simulation.state().velocity;
    return Vector3(as_points(p).colwise().sum().transpose());
  };
  const Vector3 before = momentum();
  bool touched = false;
  for (int k = 0; k < 60; ++k) {
    simulation.advance();
    touched = touched || simulation.record().contact->rows > 0;
    CHECK((momentum() - before).norm() < 1e-11 * 1e-3);  // kg m/s; each body carries 1e-3
  }
  CHECK(touched);
}

TEST_CASE("a body without supports falls and is pushed as a free mass") {
  Scene scene = scenes::tissue_scene(block_mesh({{0, 0, 0}, {0.02, 0.01, 0.01}, {2, 1, 1}}), 0.3, 0.1);
  scene.gravity = Vector3(0, 0, -9.81);
  scene.loads = {{"x_max", {100, 0, 0}, 0.0, 0.0}};
  Simulation simulation(scene, options(HilberHughesTaylor{}, 1e-4));
  const double mass = 1040 * 2e-6, force = 100 * 1e-4;
  for (int k = 0; k < 50; ++k) simulation.advance();
  const double t = simulation.time();
  const Vector p = simulation.mass() * simulation.state().velocity;
  const Vector3 velocity = as_points(p).colwise().sum().transpose() / mass;
  CHECK(velocity[0] == approx(force / mass * t).epsilon(1e-10));
  CHECK(velocity[2] == approx(-9.81 * t).epsilon(1e-10));
  CHECK(std::abs(velocity[1]) < 1e-12);
  const Vector moved = simulation.mass() * simulation.state().displacement;  // of the centre of mass
  CHECK(as_points(moved).col(2).sum() / mass == approx(-0.5 * 9.81 * t * t).epsilon(1e-9));
}

TEST_CASE("creep follows the Kelvin-Voigt law") {
  // Density so small that inertia plays no part: (L / c)^2 / tau^2 = 2e-8.
  const double E = 20e3, eta = 1e4, tau = eta / E, traction = 40, h = 0.005;
  for (const double nu : {0.0, 0.45}) {
    Scene scene = scenes::tissue_scene(block_mesh({{0, 0, 0}, {0.01, 0.01, 0.01}, {1, 1, 1}}), nu, eta, 1.0);
    for (int c = 0; c < 3; ++c)
      for (const auto node : scene.mesh.node_set(std::string(1, "xyz"[c]) + "_min")) scene.supports.fix(node, c);
    scene.loads = {{"x_max", {traction, 0, 0}, 0.0, 0.0}};
    Simulation simulation(scene, options(Newmark{}, h));
    const double deviatoric = eta * (1 + nu) / E, volumetric = eta * (1 - 2 * nu) / E;
    const double of_volume = (1 - 2 * nu) / 3, of_shape = 2 * (1 + nu) / 3;  // shares of the final strain
    for (int k = 1; k <= 200; ++k) {
      simulation.advance();
      const double t = k * h;
      const double strain = simulation.state().displacement[3 * scene.mesh.node_set("x_max")[0]] / 0.01;
      const double exact =
          traction / E *
          (of_volume * (1 - std::exp(-t / volumetric)) + of_shape * (1 - std::exp(-t / deviatoric)));
      // Second order in h / tau, 1e-5 at nu = 0; the volumetric part (tau = 0.05 s) begins within the first steps.
      CHECK(strain == approx(exact).epsilon(1e-3).scale(0.1 * traction / E));
    }
    if (nu == 0.45) CHECK(of_volume + of_shape * (1 - std::exp(-tau / deviatoric)) == approx(0.515).epsilon(1e-3));
  }
}

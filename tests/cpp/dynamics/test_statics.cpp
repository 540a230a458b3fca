#include <doctest/doctest.h>

#include "../approx.hpp"
#include "plica/core/error.hpp"
#include "plica/dynamics/statics.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

/// A quadratic bar of 20 mm along x, held at x = 0, nu = 0, gravity along it.
Scene hanging_bar() {
  Scene scene =
      scenes::tissue_scene(to_quadratic(block_mesh({{0, 0, 0}, {0.02, 0.01, 0.01}, {3, 1, 1}})), 0.0, 0.0);
  for (const auto node : scene.mesh.node_set("x_min")) scene.supports.fix(node);
  scene.gravity = Vector3(9.81, 0, 0);
  return scene;
}

}  // namespace

TEST_CASE("a hanging bar stretches as its closed form says") {
  Scene scene = hanging_bar();
  scene.loads = {{"x_max", {50, 0, 0}, 80.0, 0.4}};  // at t = 0: 50 cos(0.4) Pa
  const Points u = equilibrium(scene);
  const double L = 0.02, E = 20e3, rho = 1040;
  for (std::ptrdiff_t i = 0; i < u.rows(); ++i) {
    const double x = scene.mesh.points(i, 0);
    const double exact = rho * 9.81 * (L * x - x * x / 2) / E + 50 * std::cos(0.4) * x / E;
    CHECK((u.row(i).transpose() - Vector3(exact, 0, 0)).norm() < 1e-12 * L);
  }
}

TEST_CASE("a body let go in its equilibrium stays there") {
  Scene scene = hanging_bar();
  scene.gravity = Vector3(98.1, 0, -200);  // the bar is bent by a third of its length
  const Points linear = equilibrium(scene);
  for (const bool finite : {false, true}) {
    if (finite) scene.strain = FiniteStrain{};
    scene.displacement = equilibrium(scene);
    const double size = scene.displacement->cwiseAbs().maxCoeff();
    CHECK(((*scene.displacement - linear).cwiseAbs().maxCoeff() > 0.1 * size) == finite);
    Simulation simulation(scene, options(HilberHughesTaylor{}, 1e-4));
    for (int k = 0; k < 50; ++k) simulation.advance();
    const Points moved = as_points(simulation.state().displacement) - *scene.displacement;
    CHECK(moved.cwiseAbs().maxCoeff() < 1e-10 * size);
  }
}

TEST_CASE("a body that can move without strain has no equilibrium, and the message says how it moves") {
  Scene free = hanging_bar();
  free.supports = Supports(free.mesh.node_count());
  CHECK_THROWS_WITH_AS(equilibrium(free),
                       doctest::Contains("Scene: the body of node 0, centred at (0.01, 0.005, 0.005) m, can "),
                       InvalidInput);

  Scene sliding = free;
  for (const auto node : free.mesh.node_set("x_min")) {
    sliding.supports.fix(node, 0);
    sliding.supports.fix(node, 1);
  }
  CHECK_THROWS_WITH_AS(equilibrium(sliding), doctest::Contains("shift along (0, 0, "), InvalidInput);

  Scene hinged = free;  // about the edge x = 0, y = 0
  for (const auto node : free.mesh.node_set("x_min"))
    if (free.mesh.points(node, 1) == 0) hinged.supports.fix(node);
  CHECK_THROWS_WITH_AS(equilibrium(hinged), doctest::Contains("turn about (0, 0, "), InvalidInput);

  Scene two = scenes::two_cubes(Multipliers{});
  two.supports = Supports(two.mesh.node_count());
  for (const auto node : two.mesh.node_set("a.x_min")) two.supports.fix(node);
  CHECK_THROWS_WITH_AS(equilibrium(two), doctest::Contains("must be held for an equilibrium"),
                       InvalidInput);  // the second cube
  for (const auto node : two.mesh.node_set("b.x_max")) two.supports.fix(node);
  CHECK_NOTHROW(equilibrium(two));
}

TEST_CASE("pressed together at rest, blocks share the load as one, at nodes and on mortar faces") {
  // Two quadratic blocks that touch, the far end of one pushed by 10 um: uniform strain, as of one block.
  const double side = 0.01, push = 1e-5;
  const TetMesh a = to_quadratic(block_mesh({{-side, 0, 0}, {side, side, side}, {1, 2, 2}})),
                b = to_quadratic(block_mesh({{0, 0, 0}, {side, side, side}, {2, 2, 2}}));
  Scene scene = scenes::tissue_scene(combine_meshes(a, b, "a.", "b."), 0.0, 0.0);
  for (const auto node : scene.mesh.node_set("a.x_min")) scene.supports.fix(node);
  for (const auto node : scene.mesh.node_set("b.x_max")) scene.supports.fix(node);
  scene.displacement = Points::Zero(scene.mesh.node_count(), 3);
  for (const auto node : scene.mesh.node_set("b.x_max")) (*scene.displacement)(node, 0) = -push;
  scene.contact = scenes::contact_of(scene.mesh, "a.x_max", "b.x_min", Multipliers{});
  scene.contact->options.tolerance = 1e-8;
  for (const FaceMethod& faces :
       {FaceMethod(AtNodes{}), FaceMethod(Mortar{scene.mesh.surface("a.x_max"), scene.mesh.surface("b.x_min")})}) {
    scene.contact->faces = faces;
    const ContactEquilibrium rest = contact_equilibrium(scene);
    const double strain = 0.5 * push / side, pressure = 20e3 * strain;
    for (std::ptrdiff_t i = 0; i < rest.displacement.rows(); ++i) {
      const double exact = -strain * (scene.mesh.points(i, 0) + side);
      CHECK((rest.displacement.row(i).transpose() - Vector3(exact, 0, 0)).norm() < 1e-6 * push);
    }
    CHECK(as_points(rest.contact_force).bottomRows(b.node_count()).col(0).sum() ==
          approx(pressure * side * side).epsilon(1e-6));
    CHECK(rest.contact_pressure.size() == scene.mesh.node_count());
    if (std::holds_alternative<Mortar>(faces))
      for (const auto node : scene.mesh.node_set("b.x_min"))
        CHECK(rest.contact_pressure[node] == approx(pressure).epsilon(1e-5));
  }
  scene.contact->faces = AtNodes{};
  scene.strain = FiniteStrain{};
  CHECK_THROWS_WITH_AS(contact_equilibrium(scene), doctest::Contains("strain = finite; must be without"),
                       InvalidInput);
  scene.strain.reset();
  scene.contact->enforcement = Nitsche{};
  CHECK_THROWS_WITH_AS(contact_equilibrium(scene), doctest::Contains("must be multipliers"), InvalidInput);
  scene.contact->enforcement = Augmented{1e-3, 10.0, 0.75, 1};
  CHECK_THROWS_WITH_AS(contact_equilibrium(scene), doctest::Contains("after 1 augmentations at rest"),
                       SolveFailed);
  scene.contact.reset();
  CHECK_THROWS_WITH_AS(contact_equilibrium(scene), doctest::Contains("Scene: contact is missing"), InvalidInput);
}

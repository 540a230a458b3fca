#include <doctest/doctest.h>

#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "scenes.hpp"

using namespace plica;
using namespace scenes;

namespace {

constexpr double facing_step = 50e-6;

/// Folds thrown against each other, solved for on a quarter; passes enough to settle, or one, which settles
/// nothing.
Scene colliding_images(int max_passes, Symmetry symmetry = Symmetry::quarter) {
  Scene scene = small_larynx();
  for (std::ptrdiff_t i = 0; i < scene.mesh.node_count(); ++i)
    if (scene.mesh.points(i, 0) == 0) scene.velocity->row(i).setZero();
  scene.symmetry = symmetry;
  scene.contact->options = {1e-8, max_passes};
  return scene;
}

}  // namespace

TEST_CASE("mirror images that are held by facing nodes move as passes between their surfaces lead them") {
  for (const Symmetry symmetry : cases({Symmetry::quarter, Symmetry::half})) {
    Simulation usual(colliding_images(200, symmetry), options(HilberHughesTaylor{}, facing_step)),
        facing(colliding_images(1, symmetry), options(HilberHughesTaylor{}, facing_step));
    int held = 0;
    for (int k = 0; k < 40; ++k) {
      usual.advance();
      facing.advance();
      const ContactRecord &one = *usual.record().contact, &other = *facing.record().contact;
      CHECK_FALSE(one.facing);
      CHECK(relative(facing.displacement(), usual.displacement()) < 1e-5);
      CHECK((other.force_first - one.force_first).norm() < 1e-3 * one.force_first.norm() + 1e-9);
      CHECK((other.rows > 0) == (one.rows > 0));
      CHECK(other.converged);
      CHECK(other.largest_multiplier <= 0);
      CHECK(other.deepest_gap > -1e-7 * facing.collision()->detector().mean_edge());
      held += other.facing;
    }
    CHECK(held > 5);
    const Ledger& ledger = facing.state().ledger;
    CHECK(std::abs(ledger.error()) < 1e-11 * ledger.initial);
  }
}

TEST_CASE("a scene without facing nodes still fails where passes do") {
  Scene scene = colliding_images(1);
  scene.contact->friction = Friction{0.3};
  Simulation simulation(scene, options(HilberHughesTaylor{}, facing_step));
  const auto go_on = [&] {
    for (int k = 0; k < 40; ++k) simulation.advance();
  };
  CHECK_THROWS_WITH_AS(go_on(), doctest::Contains("after 1 passes"), SolveFailed);
}

TEST_CASE("steps of facing nodes go on from a restored state as if they had not stopped, on any threads") {
  Simulation one(colliding_images(1), options(HilberHughesTaylor{}, facing_step)),
      other(colliding_images(1), options(HilberHughesTaylor{}, facing_step));
  int held = 0;
  for (int k = 0; k < 30; ++k) {
    other.restore(one.state());
    set_threads(2);
    other.advance();
    set_threads(1);
    one.advance();
    CHECK(other.state().displacement == one.state().displacement);
    CHECK(other.contact_force() == one.contact_force());
    CHECK(other.contact_pressure() == one.contact_pressure());
    held += one.record().contact->facing;
  }
  CHECK(held > 3);
}

TEST_CASE("folds unlike each other that are held by facing nodes stay near the motion of passes") {
  Scene scene = small_larynx();
  for (std::ptrdiff_t i = 0; i < scene.mesh.node_count(); ++i)
    if (scene.mesh.points(i, 0) < 0) scene.velocity->row(i) *= 0.6;
  Scene facing_scene = scene;
  facing_scene.contact->options.max_passes = 1;
  Simulation usual(scene, options(HilberHughesTaylor{}, facing_step)),
      facing(facing_scene, options(HilberHughesTaylor{}, facing_step));
  int held = 0;
  double largest = 0;
  for (int k = 0; k < 40; ++k) {
    usual.advance();
    facing.advance();
    held += facing.record().contact->facing;
    largest = std::max(largest, relative(facing.displacement(), usual.displacement()));
  }
  CHECK(held > 3);
  CHECK(largest > 0);
  CHECK(largest < 0.02);
  CHECK(std::abs(facing.state().ledger.error()) < 1e-9 * facing.state().ledger.initial);
}

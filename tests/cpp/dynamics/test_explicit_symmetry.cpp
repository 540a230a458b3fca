// Explicit steps of the part of a symmetric scene beside those of all of it.
#include <doctest/doctest.h>

#include "../approx.hpp"
#include "plica/core/error.hpp"
#include "reduced_scenes.hpp"

using namespace plica;
using namespace scenes;

TEST_CASE("explicit steps of a symmetric part are those of the whole, its air and its energy") {
  for (const Coupling& coupling : {Coupling(Lagged{}), Coupling(Extrapolated{})})
    for (const Symmetry symmetry : {Symmetry::half, Symmetry::quarter}) {
      Scene scene = symmetric_folds();
      scene.airflow->coupling = coupling;
      scene.airflow->flow.model = ViscousSlit{};
      scene.airflow->flow.area = CutSections{12};
      scene.contact->enforcement = Penalty{1.0};
      *scene.velocity *= 4;
      Simulation::Options how = options(CentralDifferences{}, 4e-7);
      how.mass = Simulation::Mass::lumped;
      Simulation whole(scene, how);
      scene.symmetry = symmetry;
      Simulation part(scene, how);
      CHECK(part.state().displacement.size() < whole.state().displacement.size());
      CHECK(*part.largest_step() > 0.999 * *whole.largest_step());  // fewer motions are possible
      int touching = 0;
      for (int k = 0; k < 2500; ++k) {
        whole.advance();
        part.advance();
        touching += whole.record().contact->rows > 0;
        // The penalty's slaves are of one side, which the whole leans to and the part does not.
        const double apart = touching ? 2e-2 : 1e-9;
        if (k % 50) continue;
        CHECK(relative(part.displacement(), whole.displacement()) < apart);
        CHECK(relative(part.record().flow->state.area, whole.record().flow->state.area) < apart);
        CHECK(part.state().ledger.kinetic == approx(whole.state().ledger.kinetic).epsilon(apart));
        CHECK(std::abs(part.state().ledger.error()) < 1e-10 * part.state().ledger.initial);
      }
      CHECK(touching > 100);
    }
}

TEST_CASE("a symmetric part is stable up to its own largest step, where the whole is not") {
  Scene scene = symmetric_folds();
  scene.airflow.reset();
  scene.contact->enforcement = Penalty{1.0};
  *scene.velocity *= 4;
  Simulation::Options how = options(CentralDifferences{}, 1e-7);
  how.mass = Simulation::Mass::lumped;
  const double whole = *Simulation(scene, how).largest_step();
  scene.symmetry = Symmetry::half;
  how.step = 0.98 * *Simulation(scene, how).largest_step();
  REQUIRE(how.step > 1.5 * whole);
  Simulation part(scene, how);
  for (int k = 0; k < 4000; ++k) {
    part.advance();
    if (k % 500) continue;
    const Ledger& ledger = part.state().ledger;
    CHECK(ledger.kinetic + ledger.elastic < 1.1 * ledger.initial);
    CHECK(std::abs(ledger.error()) < 1e-9 * ledger.initial);
  }
  scene.symmetry.reset();
  CHECK_THROWS_WITH_AS(Simulation(scene, how), doctest::Contains("must be <= "), InvalidInput);
}

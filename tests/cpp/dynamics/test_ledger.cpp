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

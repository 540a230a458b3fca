// What a failed step says of the trouble that came before it.
#include <doctest/doctest.h>

#include <string>

#include "plica/core/error.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

/// What is said when a step fails, here under a force that is finite, but whose square is not.
std::string failure(Simulation& simulation) {
  const std::ptrdiff_t unknowns = simulation.step_matrix().rows();
  simulation.set_external_force(Vector::Constant(unknowns, 1e300));
  try {
    simulation.advance();
  } catch (const SolveFailed& failed) {
    simulation.set_external_force(Vector::Zero(unknowns));
    return failed.what();
  }
  return "did not fail";
}

bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// A block with a node of its free end 20 mm away: through the cells that it belongs to.
Scene folded_block() {
  Scene scene = scenes::held_block();
  scene.displacement = Points::Zero(scene.mesh.node_count(), 3);
  const auto node = scene.mesh.node_set("x_max")[0];
  scene.displacement->row(node) << -20e-3, 0, 0;
  return scene;
}

}  // namespace

TEST_CASE("a failure without trouble before it speaks of itself alone") {
  Simulation simulation(scenes::held_block(), options(HilberHughesTaylor{}, 1e-4));
  simulation.advance();
  const std::string text = failure(simulation);
  CHECK_MESSAGE(text.find("Step 2 (t = 0.0002 s): ") == 0, text);
  CHECK_MESSAGE(says(text, "|b| = inf"), text);
  CHECK_MESSAGE(!says(text, "First sign"), text);
}

TEST_CASE("tissue folded at the start is the first sign, at t = 0 and in its lowest cell") {
  Simulation simulation(folded_block(), options(HilberHughesTaylor{}, 1e-4));
  const Points x = simulation.positions();
  const Vector volumes = signed_volumes(x, simulation.scene().mesh.cells);
  std::ptrdiff_t count = 0, lowest = -1;
  for (std::ptrdiff_t e = volumes.size() - 1; e >= 0; --e)
    if (volumes[e] <= 0) ++count, lowest = e;
  REQUIRE(count > 0);
  const std::optional<FoldedTissue> sign = simulation.state().first_signs.folded_tissue;
  REQUIRE(sign.has_value());
  CHECK(sign->step == 0);
  CHECK(sign->count == count);
  CHECK(sign->cell == lowest);
  const std::string text = failure(simulation);
  CHECK_MESSAGE(says(text, " First sign: at t = 0 s " + std::to_string(count) + " of " +
                               std::to_string(volumes.size()) + " tissue cells folded"),
                text);
  CHECK_MESSAGE(says(text, "m; " + std::to_string(count) + " are now. Linear tissue"), text);
}

TEST_CASE("an iteration of air and tissue that ran out is named with its residual, first where it came first") {
  Scene scene = scenes::small_larynx();
  scene.airflow->coupling = Iterated{1e-15, 2, 1};
  Simulation simulation(scene, options(HilberHughesTaylor{}, 1e-4, 1e-8));
  simulation.advance();
  REQUIRE_FALSE(simulation.record().flow->converged);
  const double residual = simulation.record().flow->residual;
  simulation.advance();
  const std::string text = failure(simulation);
  CHECK_MESSAGE(says(text, " First sign: at t = 0.0001 s air and tissue did not agree (coupling's residual " +
                               number_text(residual) + " subglottal pressures)"),
                text);
  CHECK_MESSAGE(says(text, "Try a smaller step, or a larger max_sweeps."), text);

  State state = simulation.state();
  state.first_signs.folded_tissue = FoldedTissue{2, 3, 7, Vector3(1, 2, 3)};
  simulation.restore(state);
  const std::string both = failure(simulation);
  CHECK_MESSAGE(says(both, ". Then, at t = 0.0002 s 3 of " + std::to_string(scene.mesh.cell_count()) +
                               " tissue cells folded, the first cell 7 at (1, 2, 3) m; "),
                both);
  CHECK_MESSAGE(!says(both, "Linear tissue"), both);
  state.first_signs.folded_tissue->step = 0;
  simulation.restore(state);
  const std::string turned = failure(simulation);
  CHECK_MESSAGE(says(turned, " First sign: at t = 0 s 3 of "), turned);
  CHECK_MESSAGE(says(turned, ". Then, at t = 0.0001 s air and tissue"), turned);

  state.first_signs.folded_tissue->step = 3;
  CHECK_THROWS_WITH_AS(simulation.restore(state),
                       doctest::Contains("step of folded tissue = 3; must be in [0, 2]"), InvalidInput);
  state.first_signs.folded_tissue->step = 2;
  state.first_signs.folded_tissue->cell = 1'000'000;
  CHECK_THROWS_WITH_AS(simulation.restore(state), doctest::Contains("folded cell"), InvalidInput);
}

TEST_CASE("contact that was left open is named with its gap error") {
  Augmented few;
  few.max_augmentations = 1;
  Simulation simulation(scenes::two_cubes(few), options(HilberHughesTaylor{}, 1e-4));
  while (!simulation.record().contact || simulation.record().contact->converged) {
    REQUIRE(simulation.time() < 2e-3);
    simulation.advance();
  }
  const std::string expected = " First sign: at t = " + number_text(simulation.time()) +
                               " s contact was left with a gap error of " +
                               number_text(simulation.record().contact->gap_error) + " m";
  simulation.advance();
  const std::string text = failure(simulation);
  CHECK_MESSAGE(says(text, expected), text);
}

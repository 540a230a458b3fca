// What of the tissue must be alike in mirror images, and the explicit step that their contact allows.
#include <doctest/doctest.h>

#include <cmath>

#include "plica/core/error.hpp"
#include "plica/dynamics/symmetric_part.hpp"
#include "reduced_scenes.hpp"

using namespace plica;
using namespace scenes;

TEST_CASE("a posture is mirrored, unless it moves nothing but round-off") {
  Scene scene = tissue_scene(symmetric_folds().mesh, 0.3, 0.0);
  scene.symmetry = Symmetry::half;
  for (const double moved : {1e-20, 1e-6}) {
    scene.mesh.rest = scene.mesh.points;
    for (std::ptrdiff_t i = 0; i < scene.mesh.rest.rows(); ++i) scene.mesh.rest(i, 1) += moved * std::sin(7.0 * i);
    // Also what is left of it beside the places' own digits.
    scene.mesh.rest(3, 0) += 1e-18;
    if (moved < 1e-12)
      CHECK_NOTHROW(SymmetricPart{scene});
    else
      CHECK_THROWS_WITH_AS(SymmetricPart{scene}, doctest::Contains("the posture (m) at node"), InvalidInput);
  }
}

TEST_CASE("a fibre is mirrored in both planes, and each copy has the other constants of the others") {
  Scene scene = tissue_scene(symmetric_folds().mesh, 0.3, 0.0);
  scene.symmetry = Symmetry::quarter;
  Tissue& tissue = scene.tissue;
  tissue.materials.clear();
  tissue.names.clear();
  for (int copy = 0; copy < 4; ++copy) {
    TransverselyIsotropic oblique;
    oblique.fibre = Vector3(copy & 1 ? -0.5 : 0.5, copy & 2 ? -0.7 : 0.7, 0.4);
    tissue.materials.push_back({oblique, 1040.0, 0.2});
    tissue.names.push_back("quarter " + std::to_string(copy));
  }
  for (std::int32_t c = 0; c < scene.mesh.cell_count(); ++c) {
    const Vector3 at = scene.mesh.points(scene.mesh.cells.row(c), Eigen::all).colwise().mean();
    tissue.cell_material[c] = (at[0] < 0 ? 1 : 0) + (at[1] < 0 ? 2 : 0);
  }
  CHECK_NOTHROW(SymmetricPart{scene});
  for (std::size_t copy = 0; copy < 4; ++copy) {
    CAPTURE(copy);
    const auto refused = [&](const auto& change) {
      Scene other = scene;
      change(other.tissue.materials[copy]);
      CHECK_THROWS_WITH_AS(SymmetricPart{other}, doctest::Contains("is not the mirror image of"), InvalidInput);
      CHECK_THROWS_WITH_AS(SymmetricPart{other},
                           doctest::Contains("stiffening, matrix_stiffening and active stress"), InvalidInput);
    };
    refused([](Material& material) { material.density += 1.0; });
    refused([](Material& material) { material.viscosity += 0.01; });
    refused([](Material& material) { material.stiffening = 1.0; });
    refused([](Material& material) { material.matrix_stiffening = 1.0; });
    refused([](Material& material) { material.active_stress = 1e3; });
    for (int axis = 0; axis < 3; ++axis)
      refused(
          [axis](Material& material) { std::get<TransverselyIsotropic>(material.elasticity).fibre[axis] *= -1; });
  }
}

TEST_CASE("a stiff penalty allows a symmetric part the explicit steps of the whole, and hardly longer ones") {
  Scene scene = symmetric_folds();
  scene.contact->enforcement = Penalty{1e6};
  Simulation::Options how = options(CentralDifferences{}, 1e-10);
  how.mass = Simulation::Mass::lumped;
  const double of_whole = *Simulation(scene, how).largest_step();
  for (const Symmetry symmetry : {Symmetry::half, Symmetry::quarter}) {
    scene.symmetry = symmetry;
    const double share = *Simulation(scene, how).largest_step() / of_whole;
    CHECK(share > 1 - 1e-3);
    CHECK(share < 1.1);
  }
}

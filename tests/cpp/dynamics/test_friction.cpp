#include <doctest/doctest.h>

#include <cmath>

#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

constexpr double side = 0.01;

/// A stiff cube of 10 mm that rests on a fixed plate whose surface x = 0 is two triangles, under gravity turned by
/// `slope` (rad) about z, so that it pulls along +y: a block on an incline.
Scene incline(double slope, std::optional<Friction> friction, const Enforcement& enforcement = Multipliers{}) {
  const double far = 10 * side;
  const TetMesh plate = block_mesh({{-side, -far, -far}, {side, 2 * far, 2 * far}, {1, 1, 1}}),
                block = block_mesh({{0, -side / 2, -side / 2}, {side, side, side}, {1, 2, 2}});
  Scene scene = scenes::tissue_scene(combine(plate, block, "a.", "b."), 0.0, 0.0, 1000.0);
  scene.tissue.materials[0].elasticity = Isotropic{1e6, 0.0};
  for (std::int32_t i = 0; i < plate.node_count(); ++i) scene.supports.fix(i);
  scene.gravity = 9.81 * Vector3(-std::cos(slope), std::sin(slope), 0);
  const Triangles first = flat_triangles(scene.mesh.surface("a.x_max")),
                  second = flat_triangles(scene.mesh.surface("b.x_min"));
  // Each node of the block with each triangle of the plate: inside out where the node is below the plane.
  std::vector<std::int32_t> tets;
  for (const std::int32_t node : scene.mesh.node_set("b.x_min"))
    for (const auto& t : first.rowwise()) tets.insert(tets.end(), {t[0], t[1], t[2], node});
  scene.contact = ContactPart{
      Airway{first, second, Eigen::Map<const Tets>(tets.data(), static_cast<std::ptrdiff_t>(tets.size() / 4), 4)},
      enforcement,
      {},
      friction};
  // In mean edges, of which the plate's are 0.1 m long: gaps of 1e-10 m.
  scene.contact->options.tolerance = 1e-9;
  return scene;
}

/// Distance that the block's centre of mass has gone down the incline.
double gone(const Simulation& simulation) {
  const Vector u = simulation.mass() * simulation.state().displacement;
  return as_points(u).col(1).sum() / (1000.0 * side * side * side);
}

}  // namespace

TEST_CASE(
    "a block on an incline sticks below the friction angle and slides above it by g (sin - mu cos) t^2 / 2") {
  const double mu = 0.4, angle = std::atan(mu), h = 0.5e-3, end = 0.1;
  struct Case {
    Enforcement enforcement;
    bool mortar;
  };
  for (const auto& [enforcement, mortar] :
       {Case{Multipliers{}, false}, Case{Augmented{}, false}, Case{Multipliers{}, true}}) {
    for (const double slope : {angle - 0.05, angle + 0.05, angle + 0.3}) {
      CAPTURE(slope);
      CAPTURE(mortar);
      Scene scene = incline(slope, Friction{mu}, enforcement);
      if (mortar) scene.contact->faces = Mortar{scene.mesh.surface("a.x_max"), scene.mesh.surface("b.x_min")};
      Simulation simulation(scene, options(HilberHughesTaylor{}, h, 1e-12));
      double halfway = 0, loss = 0;
      while (simulation.time() < end - h / 2) {
        simulation.advance();
        loss += simulation.record().contact->friction_loss;
        if (simulation.time() < end / 2) halfway = gone(simulation);
      }
      const double free = 9.81 * end * end / 2;
      if (slope < angle) {  // gravity sets in at once: the block jumps and slips a little before it rests
        CHECK(halfway < 0.02 * free);
        CHECK(std::abs(gone(simulation) - halfway) < 1e-5 * free);
      } else {
        CHECK(gone(simulation) == doctest::Approx((std::sin(slope) - mu * std::cos(slope)) * free).epsilon(0.01));
        const double pressing = 1000 * side * side * side * 9.81 * std::cos(slope);
        CHECK(loss == doctest::Approx(mu * pressing * gone(simulation)).epsilon(0.02));
      }
    }
  }
}

TEST_CASE("without friction the block slides freely, and the force on the plate has no part along it") {
  const double slope = 0.3, h = 0.5e-3, end = 0.05;
  Simulation simulation(incline(slope, {}), options(HilberHughesTaylor{}, h, 1e-12));
  while (simulation.time() < end - h / 2) {
    simulation.advance();
    const Vector3 force = simulation.record().contact->force_first;
    // The weight shears the block by some rho g L / E = 1e-4, and its normals turn by less.
    CHECK(std::abs(force[1]) <= 1e-4 * 9.81e-3);
  }
  CHECK(gone(simulation) == doctest::Approx(9.81 * std::sin(slope) * end * end / 2).epsilon(1e-3));
}

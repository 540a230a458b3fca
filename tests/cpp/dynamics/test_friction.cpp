#include <doctest/doctest.h>

#include <cmath>

#include "../approx.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

constexpr double side = 0.01;

/// Contact of the body b with the plate a, whose surface x = 0 is two triangles.
ContactPart on_plate(const TetMesh& mesh, const Enforcement& enforcement, std::optional<Friction> friction) {
  const Triangles first = flat_triangles(mesh.surface("a.x_max")),
                  second = flat_triangles(mesh.surface("b.x_min"));
  // Each node of the body with each triangle of the plate: inside out where the node is below the plane.
  std::vector<std::int32_t> tets;
  for (const std::int32_t node : mesh.node_set("b.x_min"))
    for (const auto& t : first.rowwise()) tets.insert(tets.end(), {t[0], t[1], t[2], node});
  return {
      Airway{first, second, Eigen::Map<const Tets>(tets.data(), static_cast<std::ptrdiff_t>(tets.size() / 4), 4)},
      enforcement,
      {},
      friction};
}

/// A stiff cube of 10 mm that rests on a fixed plate whose surface x = 0 is two triangles, under gravity turned by
/// `slope` (rad) about z, so that it pulls along +y: a block on an incline.
Scene incline(double slope, std::optional<Friction> friction, const Enforcement& enforcement = Multipliers{}) {
  const double far = 10 * side;
  const TetMesh plate = block_mesh({{-side, -far, -far}, {side, 2 * far, 2 * far}, {1, 1, 1}}),
                block = block_mesh({{0, -side / 2, -side / 2}, {side, side, side}, {1, 2, 2}});
  Scene scene = scenes::tissue_scene(combine_meshes(plate, block, "a.", "b."), 0.0, 0.0, 1000.0);
  scene.tissue.materials[0].elasticity = Isotropic{1e6, 0.0};
  for (std::int32_t i = 0; i < plate.node_count(); ++i) scene.supports.fix(i);
  scene.gravity = 9.81 * Vector3(-std::cos(slope), std::sin(slope), 0);
  scene.contact = on_plate(scene.mesh, enforcement, friction);
  // In mean edges, of which the plate's are 0.1 m long: gaps of 1e-10 m.
  scene.contact->options.tolerance = 1e-9;
  return scene;
}

/// Distance that the block's centre of mass has gone down the incline.
double gone(const Simulation& simulation) {
  const Vector u = simulation.mass() * simulation.state().displacement;
  return as_points(u).col(1).sum() / (1000.0 * side * side * side);
}

/// A stiff disc of radius `side` on its point, one cell thick, axis along z, on a fixed plate x <= 0: its weight
/// pulls along -x, and it slides along +y at v0 without spin.
Scene sliding_disc(double mu, double v0) {
  constexpr int n = 8;  // cells along a quarter's two sides
  const double thick = 2 * side / n;
  TetMesh disc = block_mesh({{-1, -1, 0}, {2, 2, thick}, {n, n, 1}});
  for (std::ptrdiff_t i = 0; i < disc.node_count(); ++i) {  // squares become circles
    const double x = disc.points(i, 0), y = disc.points(i, 1), radius = std::hypot(x, y),
                 scale = radius > 0 ? side * std::max(std::abs(x), std::abs(y)) / radius : 0.0;
    disc.points(i, 0) = scale * x + side;
    disc.points(i, 1) = scale * y;
  }
  const TetMesh plate = block_mesh({{-side, -2 * side, -side}, {side, 4 * side, 4 * side}, {1, 1, 1}});
  Scene scene = scenes::tissue_scene(combine_meshes(plate, disc, "a.", "b."), 0.0, 2e4, 1000.0);
  scene.tissue.materials[0].elasticity = Isotropic{1e9, 0.0};
  for (std::int32_t i = 0; i < plate.node_count(); ++i) scene.supports.fix(i);
  scene.gravity = Vector3(-9.81, 0, 0);
  scene.velocity = Points::Zero(scene.mesh.node_count(), 3);
  scene.velocity->col(1).tail(disc.node_count()).setConstant(v0);
  scene.contact = on_plate(scene.mesh, Multipliers{}, Friction{mu});
  scene.contact->options.tolerance = 1e-9;
  return scene;
}

/// The part of a body that moves along y and turns about z.
struct Rolling {
  double mass = 0, inertia = 0, velocity = 0, spin = 0;
};
Rolling rolling(const Simulation& simulation) {
  const Points& rest = simulation.scene().mesh.points;
  const auto free = [&](std::ptrdiff_t i) {
    return !simulation.scene().supports.node_fixed(static_cast<std::int32_t>(i));
  };
  // Momenta of translation and rotation as M times the rigid motions e_y and e_z x (X - centre).
  const std::ptrdiff_t nodes = rest.rows();
  Points along = Points::Zero(nodes, 3), turn = Points::Zero(nodes, 3);
  for (std::ptrdiff_t i = 0; i < nodes; ++i)
    if (free(i)) {
      along(i, 1) = 1;
      turn.row(i) << -rest(i, 1), rest(i, 0) - side, 0;
    }
  const Vector p = simulation.mass() * Vector(as_vector(along)), l = simulation.mass() * Vector(as_vector(turn));
  Rolling found;
  found.mass = p.dot(as_vector(along));
  found.inertia = l.dot(as_vector(turn));
  found.velocity = p.dot(simulation.state().velocity) / found.mass;
  found.spin = l.dot(simulation.state().velocity) / found.inertia;
  return found;
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
        if (!mortar && simulation.record().contact->rows > 0) {  // pressure is the normal force's alone
          const Detector& detector = simulation.collision()->detector();
          double pressing = 0;
          for (const auto node : detector.second().nodes())
            pressing += simulation.contact_pressure()[node] * detector.second().tributary_area(node);
          CHECK(pressing == approx(simulation.record().contact->force_second[0]).epsilon(1e-3));
        }
        if (simulation.time() < end / 2) halfway = gone(simulation);
      }
      const double free = 9.81 * end * end / 2;
      if (slope < angle) {  // gravity sets in at once: the block jumps and slips a little before it rests
        CHECK(halfway < 0.02 * free);
        CHECK(std::abs(gone(simulation) - halfway) < 1e-5 * free);
      } else {
        // It jumps and slips a little at first.
        CHECK(std::abs(gone(simulation) - (std::sin(slope) - mu * std::cos(slope)) * free) < 2e-3 * free);
        if (!mortar) {  // by partner, which is a corner of the plate's triangles: the slide is the block's
          const double edge = simulation.collision()->detector().mean_edge();
          CHECK(simulation.record().contact->slide * edge == approx(gone(simulation)).epsilon(0.01));
        }
        const double pressing = 1000 * side * side * side * 9.81 * std::cos(slope);
        CHECK(loss == approx(mu * pressing * gone(simulation)).epsilon(0.02));
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
  CHECK(gone(simulation) == approx(9.81 * std::sin(slope) * end * end / 2).epsilon(1e-3));
}

// Rigid: friction mu m g brakes the disc and spins it up until R spin = v, at v0 / (1 + I / m R^2) (2/3 v0 where I
// is m R^2 / 2) after v0 / (mu g (1 + m R^2 / I)) (v0 / 3 mu g); it has then turned by 1e-3 rad, which the linear
// tissue does not resist.
TEST_CASE("a disc that slides without spin ends rolling: 2/3 of the speed is left, and friction took a third") {
  const double mu = 0.4, v0 = 0.02, h = 10e-6;
  Simulation simulation(sliding_disc(mu, v0), options(HilberHughesTaylor{}, h, 1e-12));
  const Rolling start = rolling(simulation);
  const double k = start.inertia / (start.mass * side * side), end = v0 / (mu * 9.81 * (1 + 1 / k));
  CHECK(k == approx(0.5).epsilon(0.03));              // of a polygon
  CHECK(std::abs(rolling(simulation).spin) < 1e-12);  // 1/s
  double stuck_from = 0, slip_impulse = 0, slip_friction = 0;
  while (simulation.time() < 2 * end) {
    simulation.advance();
    const Vector3 force = simulation.record().contact->force_second;
    const Rolling now = rolling(simulation);
    // All that turns the disc is the friction at its rim, which takes as much momentum as it gives.
    CHECK(now.inertia * now.spin == approx(now.mass * side * (v0 - now.velocity)).epsilon(1e-3));
    if (-force[1] > 0.9 * mu * force[0] && stuck_from == 0) {
      slip_impulse += h * force[0];
      slip_friction -= h * force[1];
    } else if (stuck_from == 0) {
      stuck_from = simulation.time();
    }
  }
  const Rolling found = rolling(simulation);
  CHECK(slip_friction == approx(mu * slip_impulse).epsilon(2e-3));
  CHECK(stuck_from == approx(end).epsilon(0.02));  // the weight sets in at once: the disc bounces a little
  CHECK(found.velocity == approx(v0 / (1 + k)).epsilon(1e-3));
  CHECK(found.spin * side == approx(found.velocity).epsilon(1e-3));
  const double lost = -simulation.state().ledger.contact_work / (0.5 * found.mass * v0 * v0);
  CHECK(lost == approx(k / (1 + k)).epsilon(0.01));
  CHECK(std::abs(simulation.state().ledger.error()) < 1e-9 * simulation.state().ledger.initial);
}

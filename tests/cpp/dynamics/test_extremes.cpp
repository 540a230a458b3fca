// Contact where it is hardest; benchmarks/contact/extremes.py has more cases, and all enforcements.
#include <doctest/doctest.h>

#include <algorithm>

#include "oracle.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

constexpr double edge = 0.01;

/// Two free cubes of 10 mm, 4 x 3 x 3 cells, that fly at each other at 1 m/s and slide.
Scene free_cubes(const Enforcement& enforcement, double gap = 0.5e-3, double speed = 1.0) {
  const TetMesh a = block_mesh({{-edge, 0, 0}, {edge, edge, edge}, {4, 3, 3}}),
                b = block_mesh({{gap, 0, 0}, {edge, edge, edge}, {4, 3, 3}});
  Scene scene = scenes::tissue_scene(combine_meshes(a, b, "a.", "b."), 0.3, 0.0);
  scene.velocity = Points::Zero(scene.mesh.node_count(), 3);
  scene.velocity->topRows(a.node_count()).rowwise() = Vector3(0.5 * speed, 0.15, 0).transpose();
  scene.velocity->bottomRows(b.node_count()).rowwise() = Vector3(-0.5 * speed, 0, -0.15).transpose();
  scene.contact = scenes::contact_of(scene.mesh, "a.x_max", "b.x_min", enforcement);
  return scene;
}

/// How far the deepest node of either contact surface is in the other body, m.
double depth(const Simulation& simulation) {
  const TetMesh& mesh = simulation.scene().mesh;
  const Points x = simulation.positions();
  const std::ptrdiff_t half = mesh.cell_count() / 2;
  const Cells first = mesh.cells.topRows(half), second = mesh.cells.bottomRows(half);
  const Triangles of_first = flat_triangles(mesh.surface("a.x_max")),
                  of_second = flat_triangles(mesh.surface("b.x_min"));
  double deepest = 0;
  for (const auto node : mesh.node_set("a.x_max"))
    if (oracle::in_tissue(x, second, x.row(node)))
      deepest = std::max(deepest, oracle::distance(x, of_second, x.row(node)));
  for (const auto node : mesh.node_set("b.x_min"))
    if (oracle::in_tissue(x, first, x.row(node)))
      deepest = std::max(deepest, oracle::distance(x, of_first, x.row(node)));
  return deepest;
}

}  // namespace

// Nodes slide off the other surface's rim within a step. The plane that holds them turns with the surfaces'
// normals; passes that follow it took more than the 200 there are.
TEST_CASE("surfaces without mass that a shear load drags over each other's rims stay solvable") {
  Scene scene = free_cubes(Multipliers{});
  scene.contact->surface_mass = SurfaceMass::redistributed;
  scene.loads = {{"b.x_min", {0, 0, 2000}, 0.0, 0.0}};
  Simulation simulation(scene, options(HilberHughesTaylor{}, 50e-6, 1e-10));
  const double tolerance = scene.contact->options.tolerance * simulation.collision()->detector().mean_edge();
  int passes = 0, rows = 0;
  for (int k = 0; k < 40; ++k) {
    simulation.advance();
    passes = std::max(passes, simulation.record().contact->passes);
    rows = std::max(rows, simulation.record().contact->rows);
    CHECK(depth(simulation) <= 1.01 * tolerance);
  }
  CHECK(rows >= 12);
  CHECK(passes < 50);
}

// A corner of the second cube is pushed into the first by the collision itself, further than the cubes fly in a
// step.
TEST_CASE("a node that contact forces move deeper than the bodies fly in a step is held too") {
  Scene scene = free_cubes(Multipliers{});
  scene.tissue.materials[0].viscosity = 0.5;
  for (const char* end : {"a.x_min", "b.x_max"})
    for (const auto node : scene.mesh.node_set(end)) {
      scene.supports.fix(node);
      scene.velocity->row(node).setZero();
    }
  Simulation simulation(scene, options(HilberHughesTaylor{}, 50e-6, 1e-10));
  const double tolerance = scene.contact->options.tolerance * simulation.collision()->detector().mean_edge();
  int rows = 0;
  for (int k = 0; k < 30; ++k) {
    simulation.advance();
    rows = std::max(rows, simulation.record().contact->rows);
    CHECK(simulation.record().contact->deepest_gap >= -1.01 * tolerance);
    CHECK(depth(simulation) <= 1.01 * tolerance);
  }
  CHECK(rows >= 12);
}

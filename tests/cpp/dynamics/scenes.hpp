#pragma once
#include <cmath>
#include <initializer_list>
#include <vector>

#include "plica/dynamics/simulation.hpp"
#include "plica/mesh/block.hpp"
#include "plica/mesh/edges.hpp"
#include "plica/mesh/larynx.hpp"

/// Scenes that the tests of this folder share.
namespace scenes {

using namespace plica;

/// The cases of a long test; under sanitizers, which take thirty times as long, the first alone.
template <class Case>
std::vector<Case> cases(std::initializer_list<Case> all) {
#ifdef PLICA_SANITIZE
  return {*all.begin()};
#else
  return all;
#endif
}

inline Scene tissue_scene(TetMesh mesh, double nu, double viscosity, double density = 1040.0) {
  Supports supports(mesh.node_count());
  Tissue tissue{{{Isotropic{20e3, nu}, density, viscosity}}, {"body"}, Indices::Zero(mesh.cell_count())};
  return {std::move(mesh), std::move(tissue), std::move(supports), {}, {}, {}, {}, {}, {}};
}

/// A block 20 x 10 x 10 mm held at x = 0.
inline Scene held_block(double nu = 0.3, double viscosity = 0.0) {
  Scene scene = tissue_scene(block_mesh({{0, 0, 0}, {0.02, 0.01, 0.01}, {2, 1, 1}}), nu, viscosity);
  for (const auto node : scene.mesh.node_set("x_min")) scene.supports.fix(node);
  return scene;
}

inline ContactPart contact_of(const TetMesh& mesh, const std::string& first, const std::string& second,
                              const Enforcement& enforcement) {
  return {matched_airway(mesh.points, flat_triangles(mesh.surface(first)), flat_triangles(mesh.surface(second)),
                         Vector3::UnitX()),
          enforcement,
          {},
          {}};
}

/// Two bars of 10 mm and n elements that touch at x = 0 and close at 1 m/s, on lateral rollers, nu = 0 (R3).
inline Scene two_bars(int n, const Enforcement& enforcement) {
  const double length = 0.01, w = length / n;
  const TetMesh a = block_mesh({{-length, 0, 0}, {length, w, w}, {n, 1, 1}}),
                b = block_mesh({{0, 0, 0}, {length, w, w}, {n, 1, 1}});
  Scene scene = tissue_scene(combine_meshes(a, b, "a.", "b."), 0.0, 0.0);
  const auto nodes = static_cast<std::int32_t>(scene.mesh.node_count());
  scene.velocity = Points::Zero(nodes, 3);
  for (std::int32_t i = 0; i < nodes; ++i) {
    scene.supports.fix(i, 1);
    scene.supports.fix(i, 2);
    (*scene.velocity)(i, 0) = i < a.node_count() ? 0.5 : -0.5;
  }
  scene.contact = contact_of(scene.mesh, "a.x_max", "b.x_min", enforcement);
  return scene;
}

/// The periodic bar of n elements on [0, 1], E = rho = 1, pressed by half its length on a held cube (R1): contact
/// for 1 < t < 2 with pressure 1/2, and again every 3.
inline Scene periodic_bar(int n, const Enforcement& enforcement) {
  const double w = 1.0 / n;
  const TetMesh obstacle = block_mesh({{-w, 0, 0}, {w, w, w}, {1, 1, 1}}),
                bar = block_mesh({{0, 0, 0}, {1, w, w}, {n, 1, 1}});
  Scene scene = tissue_scene(combine_meshes(obstacle, bar, "a.", "b."), 0.0, 0.0, 1.0);
  scene.tissue.materials[0].elasticity = Isotropic{1.0, 0.0};
  scene.displacement = Points::Zero(scene.mesh.node_count(), 3);
  for (std::int32_t i = 0; i < scene.mesh.node_count(); ++i) {
    scene.supports.fix(i, 1);
    scene.supports.fix(i, 2);
    if (i < obstacle.node_count()) scene.supports.fix(i);
    if (i >= obstacle.node_count()) (*scene.displacement)(i, 0) = 0.5 * (1 - scene.mesh.points(i, 0));
  }
  for (const auto node : scene.mesh.node_set("b.x_max")) scene.supports.fix(node);
  scene.contact = contact_of(scene.mesh, "a.x_max", "b.x_min", enforcement);
  return scene;
}

/// Two soft viscous cubes of 10 mm, so many cells deep, held at their far ends, 0.5 mm apart; both fly at the
/// other and slide along it.
inline Scene two_cubes(const Enforcement& enforcement, double viscosity = 0.5, int depth = 2) {
  const double side = 0.01, gap = 0.5e-3;
  const TetMesh a = block_mesh({{-side, 0, 0}, {side, side, side}, {depth, 2, 2}}),
                b = block_mesh({{gap, 0, 0}, {side, side, side}, {depth, 2, 2}});
  Scene scene = tissue_scene(combine_meshes(a, b, "a.", "b."), 0.3, viscosity);
  for (const auto node : scene.mesh.node_set("a.x_min")) scene.supports.fix(node);
  for (const auto node : scene.mesh.node_set("b.x_max")) scene.supports.fix(node);
  scene.velocity = Points::Zero(scene.mesh.node_count(), 3);
  scene.velocity->topRows(a.node_count()).rowwise() = Vector3(1.0, 0.3, 0).transpose();
  scene.velocity->bottomRows(b.node_count()).rowwise() = Vector3(-1.0, 0, -0.2).transpose();
  scene.contact = contact_of(scene.mesh, "a.x_max", "b.x_min", enforcement);
  return scene;
}

/// The scene with ten-node tetrahedra and its contact, between these surfaces, on mortar faces.
inline Scene on_mortar_faces(Scene scene, const std::string& first, const std::string& second) {
  const TetMesh linear = scene.mesh;
  scene.mesh = to_quadratic(linear);
  const auto nodes = static_cast<std::int32_t>(scene.mesh.node_count());
  Supports supports(nodes);
  std::optional<Points> velocity;
  if (scene.velocity) velocity = Points::Zero(nodes, 3);
  for (std::ptrdiff_t e = 0; e < scene.mesh.cell_count(); ++e)
    for (int k = 0; k < 10; ++k) {  // a mid-side is held, and moves, as both its ends do
      const std::int32_t node = scene.mesh.cells(e, k), a = scene.mesh.cells(e, k < 4 ? k : tet_edges[k - 4][0]),
                         b = scene.mesh.cells(e, k < 4 ? k : tet_edges[k - 4][1]);
      for (int c = 0; c < 3; ++c)
        if (scene.supports.fixed(3 * a + c) && scene.supports.fixed(3 * b + c)) supports.fix(node, c);
      if (velocity) velocity->row(node) = 0.5 * (scene.velocity->row(a) + scene.velocity->row(b));
    }
  scene.supports = supports;
  scene.velocity = velocity;
  scene.contact = contact_of(scene.mesh, first, second, scene.contact->enforcement);
  scene.contact->faces = Mortar{scene.mesh.surface(first), scene.mesh.surface(second)};
  return scene;
}

/// A larynx as coarse as can be, blown at 0.8 kPa, whose folds are thrown at each other.
inline Scene small_larynx() {
  Larynx larynx = Larynx::thesis_coarse();
  larynx.meshed = Larynx::Levels{{1, 1, 1, 1, 1, 2, 1, 1, 1, 1}, 8, 1, 1, 1};
  Scene scene = tissue_scene(larynx_mesh(larynx), 0.45, 0.2);
  for (const auto node : scene.mesh.node_set("wall")) scene.supports.fix(node);
  scene.airflow = AirflowPart{};
  scene.airflow->flow.model = Bernoulli{};  // its switches are what the coupling's tests are about
  scene.airflow->flow.area = EllipticSections{};
  scene.contact = contact_of(scene.mesh, "airway_left", "airway_right", Multipliers{});
  scene.velocity = Points::Zero(scene.mesh.node_count(), 3);
  for (std::ptrdiff_t i = 0; i < scene.mesh.node_count(); ++i)
    (*scene.velocity)(i, 0) = scene.mesh.points(i, 0) < 0 ? 1.0 : -1.0;
  return scene;
}

inline Simulation::Options options(const TimeScheme& scheme, double step, double tolerance = 1e-13) {
  return {scheme, step, {tolerance}, Simulation::Mass::consistent};
}

inline double relative(const Vector& a, const Vector& b) { return (a - b).norm() / b.norm(); }

/// The free unknowns' part of a matrix.
inline Eigen::MatrixXd free_part(const SparseMatrix& A, const std::vector<int>& unknowns) {
  const Eigen::MatrixXd dense(A);
  return dense(unknowns, unknowns);
}

/// The unknowns that no support fixes.
inline std::vector<int> free_unknowns(const Supports& supports) {
  std::vector<int> unknowns;
  for (int i = 0; i < supports.size(); ++i)
    if (!supports.fixed(i)) unknowns.push_back(i);
  return unknowns;
}

}  // namespace scenes

// R9, the contact patch test: uniform pressure through a flat interface between two meshes. Exact is a uniform
// stress; linear and quadratic tetrahedra contain its displacement, so what is off is the contact's.
#include <doctest/doctest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "../approx.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

constexpr double E = 20e3, nu = 0.3, density = 1040.0;
// Forces act at the feet of the last pass, off by the motion of that pass: the error is of the size of the strain.
constexpr double strain = 1e-6, pressure = strain * E;

/// For each node of `nodes`, the triangle of `surface` that it lies over and itself: a tetrahedron of air that
/// names them as candidates. Both lie in one plane x = const.
void add_air(const Points& points, const Triangles& surface, const Triangles& nodes,
             std::vector<std::array<std::int32_t, 4>>& tets) {
  const ContactSurface side(nodes, points.rows());
  for (const std::int32_t node : side.nodes()) {
    double best = -std::numeric_limits<double>::infinity();
    std::array<std::int32_t, 4> tet{};
    for (const auto& t : surface.rowwise()) {
      Matrix3 sides;  // of (1, y, z)
      for (int k = 0; k < 3; ++k) sides.col(k) << 1, points(t[k], 1), points(t[k], 2);
      const double inside = (sides.inverse() * Vector3(1, points(node, 1), points(node, 2))).minCoeff();
      if (inside > best) best = inside, tet = {t[0], t[1], t[2], node};
    }
    tets.push_back(tet);
  }
}

Airway air_between(const Points& points, const Triangles& first, const Triangles& second) {
  std::vector<std::array<std::int32_t, 4>> tets;
  add_air(points, first, second, tets);
  add_air(points, second, first, tets);
  Airway airway{first, second, Tets(tets.size(), 4)};
  for (std::size_t t = 0; t < tets.size(); ++t)
    airway.tets.row(static_cast<std::ptrdiff_t>(t)) = Eigen::Map<const Eigen::RowVector4i>(tets[t].data());
  return airway;
}

/// Two unit cubes of n_a^3 and n_b^3 hexahedra that touch at x = 0, the first held at its far end, the second
/// pressed there; both free to swell between rollers.
Scene patch(int order, int n_a, int n_b, const Enforcement& enforcement, bool mortar) {
  TetMesh a = block_mesh({{-1, 0, 0}, {1, 1, 1}, {n_a, n_a, n_a}}),
          b = block_mesh({{0, 0, 0}, {1, 1, 1}, {n_b, n_b, n_b}});
  if (order == 2) a = to_quadratic(a), b = to_quadratic(b);
  // A viscosity under which the slowest motion dies out within some steps.
  Scene scene = scenes::tissue_scene(combine_meshes(a, b, "a.", "b."), nu, 0.2 * std::sqrt(E * density), density);
  for (const auto node : scene.mesh.node_set("a.x_min")) scene.supports.fix(node, 0);
  for (const char* side : {"a.", "b."}) {
    for (const auto node : scene.mesh.node_set(side + std::string("y_min"))) scene.supports.fix(node, 1);
    for (const auto node : scene.mesh.node_set(side + std::string("z_min"))) scene.supports.fix(node, 2);
  }
  scene.loads = {{"b.x_max", {-pressure, 0, 0}, 0.0, 0.0}};
  const Triangles first = flat_triangles(scene.mesh.surface("a.x_max")),
                  second = flat_triangles(scene.mesh.surface("b.x_min"));
  const Points& points = scene.mesh.points;
  scene.contact = ContactPart{
      n_a == n_b ? matched_airway(points, first, second, Vector3::UnitX()) : air_between(points, first, second),
      enforcement,
      {},
      {}};
  scene.contact->options.tolerance = 1e-3 * strain;
  if (mortar) scene.contact->faces = Mortar{scene.mesh.surface("a.x_max"), scene.mesh.surface("b.x_min")};
  return scene;
}

/// Errors of the state of rest, each of its exact value.
struct PatchErrors {
  double stress;        // in the energy norm: root mean square over the volume
  double displacement;  // largest, of the shortening
  double force;         // largest of a node at the interface, of the largest exact one
  double pressure;      // largest of a node of either side
  int rows;             // closed
};

PatchErrors errors(int order, int n_a, int n_b, const Enforcement& enforcement = Multipliers{},
                   bool mortar = false) {
  const Scene scene = patch(order, n_a, n_b, enforcement, mortar);
  // Steps of five transit times: this scheme ends what is faster within two of them.
  Simulation simulation(scene, options(Newmark{1.0, 1.5}, 5 / std::sqrt(E / density), 1e-12));
  for (int k = 0; k < 20; ++k) simulation.advance();
  Points exact = scene.mesh.points;
  exact.col(0) = -strain * (exact.col(0).array() + 1);
  exact.rightCols<2>() *= nu * strain;
  const Vector u = as_vector(exact), off = simulation.state().displacement - u;
  const BlockMatrix& K = simulation.stiffness();
  REQUIRE(simulation.state().velocity.norm() * simulation.options().step < 1e-7 * u.norm());

  // The exact force of the interface on the first body is what its stiffness leaves there along x.
  const Vector forces = K * u;
  double wrong = 0, largest = 0;
  for (const auto node : scene.mesh.node_set("a.x_max")) {
    wrong = std::max(wrong, std::abs(simulation.state().contact_force[3 * node] - forces[3 * node]));
    largest = std::max(largest, std::abs(forces[3 * node]));
  }
  double off_pressure = 0;
  for (const char* side : {"a.x_max", "b.x_min"})
    for (const auto node : scene.mesh.node_set(side))
      off_pressure = std::max(off_pressure, std::abs(simulation.contact_pressure()[node] / pressure - 1));
  return {std::sqrt(off.dot(K * off) / u.dot(forces)), off.lpNorm<Eigen::Infinity>() / (2 * strain),
          wrong / largest, off_pressure, simulation.record().contact->rows};
}

}  // namespace

TEST_CASE("uniform pressure passes exactly through an interface of matched meshes, linear or quadratic") {
  for (const int order : {1, 2}) {
    CAPTURE(order);
    const PatchErrors found = errors(order, 2, 2);
    CHECK(found.stress < strain);
    CHECK(found.displacement < strain);
    CHECK(found.force < 2 * strain);
    CHECK(found.rows >= 9);
  }
}

TEST_CASE("Nitsche's method passes it exactly where the springs of its gap alone leave a penetration") {
  const double factor = 10, area = 0.25;  // of a node in the middle
  const PatchErrors found = errors(1, 2, 2, Nitsche{factor});
  CHECK(found.stress < strain);
  CHECK(found.displacement < strain);
  CHECK(found.force < 2 * strain);
  const PatchErrors springs = errors(1, 2, 2, Penalty{factor * E / 0.5 * area});
  CHECK(springs.displacement > 1000 * found.displacement);
}

TEST_CASE("with multipliers on both sides it passes between linear meshes that do not match, too") {
  for (const auto& [n_b, solver] :
       {std::pair(3, ContactSolver(Condensed{})), std::pair(4, ContactSolver(Condensed{})),
        std::pair(3, ContactSolver(Saddle{})), std::pair(3, ContactSolver(Gmres{}))}) {
    CAPTURE(n_b);
    CAPTURE(std::string(name_of(solver)));
    const PatchErrors found = errors(1, 2, n_b, Multipliers{solver, EndOfStep{}});
    CHECK(found.stress < strain);
    CHECK(found.displacement < strain);
    CHECK(found.force < 2 * strain);
    CHECK(found.rows > (n_b == 3 ? 16 : 24));  // more than the slaves of the finer side where meshes do not nest
  }
}

// Slaves of one side alone carry a uniform pressure to the wrong nodes of the other, and six-node faces in contact
// as four flat triangles do so with slaves of both: these bounds say by how much.
TEST_CASE("penalties and quadratic elements miss the uniform stress between meshes that do not match") {
  struct Case {
    int order;
    Enforcement enforcement;
    double stress, displacement, force;  // measured
  };
  const double stiff = 100 * E;  // N/m: gaps of some thousandths of the shortening
  for (const Case& expected :
       {Case{1, Penalty{stiff}, 0.063, 0.042, 0.084}, Case{2, Penalty{stiff}, 0.162, 0.113, 0.712},
        Case{2, Multipliers{}, 0.087, 0.044, 0.259}}) {
    CAPTURE(expected.order);
    CAPTURE(expected.stress);
    const PatchErrors found = errors(expected.order, 2, 3, expected.enforcement);
    CHECK(found.stress == approx(expected.stress).epsilon(0.02));
    CHECK(found.displacement == approx(expected.displacement).epsilon(0.02));
    CHECK(found.force == approx(expected.force).epsilon(0.02));
  }
}

TEST_CASE(
    "mortar faces pass it, linear or quadratic, whether the meshes match or not, and press with that pressure") {
  struct Case {
    int order, n_b;
    Enforcement enforcement;
  };
  for (const Case& chosen : {Case{1, 2, Multipliers{}}, Case{1, 3, Multipliers{}}, Case{2, 2, Multipliers{}},
                             Case{2, 3, Multipliers{}}, Case{2, 4, Multipliers{}}, Case{1, 3, Augmented{100 * E}},
                             Case{2, 3, Augmented{100 * E}}, Case{2, 3, Multipliers{Gmres{}, EndOfStep{}}}}) {
    CAPTURE(chosen.order);
    CAPTURE(chosen.n_b);
    CAPTURE(chosen.enforcement.index());
    const PatchErrors found = errors(chosen.order, 2, chosen.n_b, chosen.enforcement, true);
    CHECK(found.stress < strain);
    CHECK(found.displacement < strain);
    CHECK(found.force < 2 * strain);
    CHECK(found.pressure < 5 * strain);  // of forces at the feet of the last pass, over areas at the end
    CHECK(found.rows == (chosen.n_b + 1) * (chosen.n_b + 1));  // the corners
  }
}

TEST_CASE("a penalty on mortar faces is off by its springs' flexibility alone") {
  // Equal springs at nodes of unequal share of the area; between the meshes nothing is lost.
  for (const int n_b : {2, 3}) {
    CAPTURE(n_b);
    const double soft = errors(2, 2, n_b, Penalty{100 * E}, true).stress,
                 hard = errors(2, 2, n_b, Penalty{10000 * E}, true).stress;
    CHECK(soft < 0.02);
    CHECK(hard < 0.02 * soft);
  }
}

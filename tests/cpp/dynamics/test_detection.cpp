// Every node of one side against every tissue cell of the other body (oracle.hpp), without the airway. Over a
// whole run it must name the nodes that the detector confirms.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <random>

#include "../approx.hpp"
#include "convex_bodies.hpp"
#include "oracle.hpp"
#include "plica/core/error.hpp"
#include "plica/dynamics/tissue_overlap.hpp"
#include "plica/mesh/larynx.hpp"
#include "plica/meshing/triangulated_airway.hpp"
#include "scenes.hpp"

using namespace plica;
using namespace oracle;
using scenes::options;

namespace {

struct Agreement {
  int steps = 0;   // with a node inside
  int inside = 0;  // nodes in the other body's tissue, over all steps
  int missed = 0;  // of these, not confirmed
  int beside = 0;  // confirmed, not in the tissue, their foot nearer to the rim of the surface than to them
  int wrong = 0;   // confirmed, not in the tissue, their foot elsewhere
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;  // reference z of those inside, m
};

/// Steps through the scene. `cells`: of the bodies of first and second. Only nodes further than 1e-6 mean edges
/// from the other surface count: nearer ones are a matter of round-off.
Agreement compare(const Scene& scene, const Simulation::Options& o, int steps, const std::array<Cells, 2>& cells) {
  Simulation simulation(scene, o);
  Detector detector(scene.contact->airway, scene.mesh.points);
  const double shallow = 1e-6 * detector.mean_edge();
  Agreement found;
  for (int k = 0; k < steps; ++k) {
    const Points before = simulation.positions();
    const double depth = simulation.state().depth;
    simulation.advance();
    const Points x = simulation.positions();
    detector.renew(before, depth);
    detector.update(x);
    const double reach = detector.reach(before, x, depth);
    const int inside_before = found.inside;
    for (const bool second : {false, true}) {
      const ContactSurface& side = second ? detector.second() : detector.first();
      const ContactSurface& other = second ? detector.first() : detector.second();
      std::vector<std::int32_t> confirmed_nodes;
      for (const Pair& pair : detector.inside(side, x, reach)) confirmed_nodes.push_back(pair.slave);
      for (const std::int32_t node : side.nodes()) {
        if (other.contains(node)) continue;
        const Vector3 p = x.row(node);
        const bool inside = in_tissue(x, cells[second ? 0 : 1], p);
        const bool confirmed = std::binary_search(confirmed_nodes.begin(), confirmed_nodes.end(), node);
        if (!inside && !confirmed) continue;
        if (distance(x, other.triangles(), p) <= shallow) continue;
        found.inside += inside;
        if (inside) {
          const double z = scene.mesh.points(node, 2);
          found.lowest = std::min(found.lowest, z);
          found.highest = std::max(found.highest, z);
        }
        found.missed += inside && !confirmed;
        if (!confirmed || inside) continue;
        const Vector3 offset = detector.pair(node, x).offset(x);
        const bool at_rim = distance_to_rim(x, other.triangles(), p - offset) < offset.norm();
        ++(at_rim ? found.beside : found.wrong);
      }
    }
    found.steps += found.inside > inside_before;
  }
  return found;
}

/// The coarse larynx in the thesis's tissue with 0.35 of its viscosity, its folds thrown apart or (< 0) together,
/// the right one `stiffer` times as stiff; below z = `above` (m) they are not thrown.
Scene larynx(double opening_velocity, double driving_pressure, double stiffer = 1.0, double above = -1.0) {
  const Larynx::Shape shape;
  TetMesh mesh = larynx_mesh(Larynx::thesis_coarse());
  Supports supports(mesh.node_count());
  for (const auto node : mesh.node_set("wall")) supports.fix(node);
  Tissue tissue{{}, {}, mesh.cell_layer};
  const auto material = [](double young, double poisson, double E_fibre, double mu_fibre, double viscosity) {
    return Material{TransverselyIsotropic{young, poisson, E_fibre, poisson, mu_fibre, {}, Vector3::UnitY()},
                    1020.0, viscosity};
  };
  for (const double k : {1.0, stiffer})
    for (const std::string& layer : mesh.layer_names) {
      tissue.names.push_back(layer + (tissue.names.size() < mesh.layer_names.size() ? ".left" : ".right"));
      tissue.materials.push_back(layer == "cover"      ? material(k * 1e3, 0.66, k * 10e3, k * 10e3, 0.14)
                                 : layer == "ligament" ? material(k * 3e3, 0.58, k * 20e3, k * 40e3, 0.35)
                                                       : material(k * 20e3, 0.45, k * 40e3, k * 30e3, 0.35));
    }
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c)
    if (mesh.cell_side[c] == static_cast<std::int32_t>(Side::right))
      tissue.cell_material[c] += static_cast<std::int32_t>(mesh.layer_names.size());
  Points velocity = Points::Zero(mesh.node_count(), 3);
  for (std::ptrdiff_t i = 0; i < velocity.rows(); ++i) {
    if (mesh.points(i, 2) < above) continue;
    const double across = std::min(std::abs(mesh.points(i, 1)) / shape.major, 1.0), up = mesh.points(i, 2) / 2e-3;
    velocity(i, 0) = (mesh.points(i, 0) < 0 ? -1 : 1) * opening_velocity * std::cos(std::acos(-1.0) / 2 * across) *
                     std::exp(-up * up);
  }
  AirflowPart airflow;
  airflow.flow.subglottal_pressure = driving_pressure;
  airflow.flow.model = Bernoulli{};  // whose stop throws the folds together hardest
  airflow.flow.area = EllipticSections{};
  const ContactPart contact = scenes::contact_of(mesh, "airway_left", "airway_right", Penalty{1.0});
  return {std::move(mesh), std::move(tissue), std::move(supports), airflow, contact, {}, {}, {}, velocity};
}

/// The cells of one fold.
Cells cells_of(const TetMesh& mesh, Side side) {
  std::vector<std::ptrdiff_t> rows;
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c)
    if (mesh.cell_side[c] == static_cast<std::int32_t>(side)) rows.push_back(c);
  return mesh.cells(rows, Eigen::all);
}

}  // namespace

TEST_CASE(
    "cubes that collide and slide: what is in the other's tissue is confirmed, and nothing else but at rims") {
  const Scene scene = scenes::two_cubes(Penalty{50.0});  // soft: some tenths of an edge deep
  const auto half = scene.mesh.cell_count() / 2;
  const std::array<Cells, 2> cells{scene.mesh.cells.topRows(half), scene.mesh.cells.bottomRows(half)};
  const Agreement found = compare(scene, options(HilberHughesTaylor{}, 5e-5, 1e-8), 80, cells);
  CHECK(found.steps > 40);
  CHECK(found.inside > 300);
  CHECK(found.missed == 0);
  CHECK(found.wrong == 0);
  // Slid off the edge of the other cube by less than 60 degrees from its depth: confirmed, as matched rims must
  // be.
  CHECK(found.beside > 0);
}

TEST_CASE("phonating folds: the detector confirms the nodes in the other fold's tissue and no others") {
  struct Run {
    double opening_velocity, pressure;
    int steps;
  };
  for (const Run& run : scenes::cases({Run{1.0, 800, 65}, Run{-1.0, 1200, 75}})) {  // two collisions each
    CAPTURE(run.opening_velocity);
    const Scene scene = larynx(run.opening_velocity, run.pressure);
    const std::array<Cells, 2> cells{cells_of(scene.mesh, Side::left), cells_of(scene.mesh, Side::right)};
    CHECK(cells[0].rows() + cells[1].rows() == scene.mesh.cell_count());
    const Agreement found = compare(scene, options(HilberHughesTaylor{}, 5e-5, 1e-8), run.steps, cells);
    CHECK(found.steps > 20);
    CHECK(found.inside > 100);
    CHECK(found.missed == 0);
    CHECK(found.beside == 0);
    CHECK(found.wrong == 0);
  }
}

namespace {

/// The same scene with the air triangulated, whatever the meshes.
Scene triangulated(Scene scene) {
  Airway& airway = scene.contact->airway;
  airway = triangulated_airway(scene.mesh.points, airway.first, airway.second);
  return scene;
}

/// Two bodies `gap` (m) apart in x, whose meshes do not match; the second is held at its far end.
Scene bodies(const Block& a, const Block& b, const Enforcement& enforcement) {
  TetMesh mesh = combine_meshes(block_mesh(a), block_mesh(b), "a.", "b.");
  Scene scene = scenes::tissue_scene(std::move(mesh), 0.3, 0.5);
  for (const auto node : scene.mesh.node_set("b.x_max")) scene.supports.fix(node);
  scene.velocity = Points::Zero(scene.mesh.node_count(), 3);
  scene.contact = ContactPart{
      triangulated_airway(scene.mesh.points, scene.mesh.surface("a.x_max"), scene.mesh.surface("b.x_min")),
      enforcement,
      {}};
  return scene;
}

/// A small block that flies at a long one, is pressed on it and slides along it over several edges.
Scene sliding(const Enforcement& enforcement) {
  const Block a{{-0.01, 0.0031, 0.0021}, {0.01, 0.006, 0.006}, {3, 4, 4}},
      b{{1e-4, 0, 0}, {0.006, 0.024, 0.01}, {2, 9, 3}};
  Scene scene = bodies(a, b, enforcement);
  for (std::int32_t i = 0; i < block_mesh(a).node_count(); ++i) scene.velocity->row(i) << 0.3, 2.0, 0.1;
  scene.loads = {{"a.x_min", {1e3, 0, 0}, 0.0, 0.0}};
  return scene;
}

std::array<Cells, 2> cells_of_bodies(const Scene& scene) {
  const auto of_a = static_cast<std::int32_t>(scene.mesh.node_set("b.x_min").minCoeff());
  std::ptrdiff_t split = 0;
  while (scene.mesh.cells.row(split).maxCoeff() < of_a) ++split;
  return {scene.mesh.cells.topRows(split), scene.mesh.cells.bottomRows(scene.mesh.cell_count() - split)};
}

}  // namespace

TEST_CASE("phonating folds, symmetric or not: a triangulated airway confirms what the oracle finds and no more") {
  struct Run {
    double opening_velocity, pressure, stiffer, above;
    int steps;
  };
  // The last: the left fold twice as soft, thrown together above the glottis's middle: contact at its upper edge.
  for (const Run& run : scenes::cases(
           {Run{1.0, 800, 1.0, -1.0, 65}, Run{-1.0, 1200, 1.0, -1.0, 75}, Run{-1.5, 1200, 2.0, -1e-3, 200}})) {
    CAPTURE(run.opening_velocity);
    const Scene scene = triangulated(larynx(run.opening_velocity, run.pressure, run.stiffer, run.above));
    const std::array<Cells, 2> cells{cells_of(scene.mesh, Side::left), cells_of(scene.mesh, Side::right)};
    const Agreement found = compare(scene, options(HilberHughesTaylor{}, 5e-5, 1e-8), run.steps, cells);
    CHECK(found.steps > 20);
    CHECK(found.inside > 100);
    CHECK(found.highest == -0.4e-3);  // the upper edge, S26
    CHECK(found.missed == 0);
    CHECK(found.beside == 0);
    CHECK(found.wrong == 0);
  }
}

TEST_CASE("folds collide alike in a matched and in a triangulated airway") {
  for (const bool exact : scenes::cases({false, true})) {
    CAPTURE(exact);
    Scene scene = larynx(-1.0, 1200);
    if (exact) scene.contact->enforcement = Multipliers{};
    const Simulation::Options o = options(HilberHughesTaylor{}, 5e-5, 1e-10);
    Simulation by_match(scene, o), by_air(triangulated(scene), o);
    const double tolerance = scene.contact->options.tolerance * by_match.collision()->detector().mean_edge();
    int touching = 0;
    for (int k = 0; k < 75; ++k) {
      by_match.advance();
      by_air.advance();
      const ContactRecord &one = *by_match.record().contact, &other = *by_air.record().contact;
      touching += one.rows > 0;
      CHECK(one.rows == other.rows);
      CHECK((by_match.positions() - by_air.positions()).cwiseAbs().maxCoeff() < 1e-3 * tolerance);
    }
    CHECK(touching > 10);
  }
}

TEST_CASE("blocks whose meshes do not match slide over each other by several edges: none inside is missed") {
  const Scene scene = sliding(Penalty{5.0});
  const Agreement found = compare(scene, options(HilberHughesTaylor{}, 5e-5, 1e-8), 80, cells_of_bodies(scene));
  CHECK(found.steps > 40);
  CHECK(found.inside > 500);
  CHECK(found.missed == 0);
  CHECK(found.wrong == 0);
  CHECK(20 * found.beside < found.inside);  // nodes of the long block that the rim of the other just passes
}

TEST_CASE("multipliers keep sliding blocks apart, and a run goes on from a state in the middle as it did") {
  const Scene scene = sliding(Multipliers{});
  const Simulation::Options o = options(HilberHughesTaylor{}, 5e-5, 1e-8);
  Simulation whole(scene, o), resumed(scene, o);
  const double edge = whole.collision()->detector().mean_edge();
  int touching = 0;
  for (int k = 0; k < 80; ++k) {
    if (k == 40) resumed.restore(whole.state());
    const Points before = whole.positions();
    whole.advance();
    touching += whole.record().contact->rows > 0;
    CHECK(whole.record().contact->deepest_gap >= -2e-5 * edge);
    if (k == 60)
      CHECK(whole.collision()->detector().airway().tets ==
            triangulated_airway(before, scene.contact->airway.first, scene.contact->airway.second).tets);
    if (k < 40) continue;
    resumed.advance();
    REQUIRE(resumed.state().displacement == whole.state().displacement);
    REQUIRE(resumed.state().closed == whole.state().closed);
    REQUIRE(resumed.state().contact_force == whole.state().contact_force);
  }
  CHECK(touching > 20);
  CHECK(whole.state().displacement[3 * scene.mesh.node_set("a.x_max")[0] + 1] > 2.5 * edge);
}

TEST_CASE("deep in each other after one large step: none inside is missed") {
  for (const double step : {1e-3, 2e-3}) {  // 2 and 4 mm of motion, half and all of an edge
    CAPTURE(step);
    Scene scene = bodies({{-0.01, 0.0005, 0.0005}, {0.01, 0.009, 0.009}, {3, 3, 3}},
                         {{5e-4, 0, 0}, {0.01, 0.01, 0.01}, {2, 2, 2}}, Penalty{0.1});
    for (const auto node : scene.mesh.node_set("a.x_min")) scene.supports.fix(node);
    for (std::ptrdiff_t i = 0; i < 64; ++i) (*scene.velocity)(i, 0) = 2.0;
    const Agreement found = compare(scene, options(HilberHughesTaylor{}, step, 1e-8), 4, cells_of_bodies(scene));
    CHECK(found.inside > 20);
    CHECK(found.missed == 0);
    CHECK(found.wrong == 0);
  }
}

// Faces of the Delaunay tetrahedra are not those of a curved surface, and the air over a large face has few
// tetrahedra: inverted ones alone miss 276 of these 4055 nodes.
TEST_CASE("between curved surfaces of unlike meshes none inside is missed, shallow or deep") {
  std::mt19937 random(1);
  const auto between = [&](double low, double high) { return low + (high - low) * (random() / 4294967296.0); };
  int inside = 0, missed = 0, wrong = 0;
  for (const auto& [n_a, n_b] : {std::pair{4, 3}, {4, 5}, {9, 3}, {16, 3}})
    for (int trial = 0; trial < 6; ++trial) {
      const double curved = std::array{0.0, 0.15, 0.4}[trial % 3], phase = between(0, 6),
                   other_phase = between(0, 6);
      const Block a{{-1, 0, 0}, {1, 1, 1}, {2, n_a, n_a}}, b{{0, -0.1, -0.1}, {1, 1.2, 1.2}, {2, n_b, n_b}};
      const TetMesh mesh = combine_meshes(block_mesh(a), block_mesh(b), "a.", "b.");
      const auto of_b = mesh.node_set("b.x_min")[0];
      const std::array<Cells, 2> cells{mesh.cells.topRows(12 * n_a * n_a), mesh.cells.bottomRows(12 * n_b * n_b)};
      Points x = mesh.points;
      x.col(0).array() +=
          curved * (3 * x.col(1).array() + phase).sin() * (2.5 * x.col(2).array() + other_phase).cos();
      while (node_in_tissue(x, mesh.cells, mesh.node_set("a.x_max"), 1e-9) ||
             node_in_tissue(x, mesh.cells, mesh.node_set("b.x_min"), 1e-9))
        x.bottomRows(x.rows() - of_b).col(0).array() += 0.002;
      Detector detector(triangulated_airway(x, mesh.surface("a.x_max"), mesh.surface("b.x_min")), x);
      detector.renew(x, 0.0);
      for (const double far : {0.01, 0.05, 0.15}) {
        Points moved = x;
        const Vector3 shift(-between(0, far), between(-far, far), between(-far, far));
        moved.bottomRows(x.rows() - of_b).rowwise() += shift.transpose();
        const double along_y = between(0, 5), along_z = between(0, 5);
        moved.col(0).head(of_b).array() +=
            0.5 * far * (along_y * x.col(1).head(of_b).array() + along_z * x.col(2).head(of_b).array()).sin();
        detector.update(moved);
        const double reach = detector.reach(x, moved, 0.0);
        for (const bool second : {false, true}) {
          const ContactSurface& side = second ? detector.second() : detector.first();
          const ContactSurface& other = second ? detector.first() : detector.second();
          std::vector<char> confirmed(static_cast<std::size_t>(x.rows()), 0);
          for (const Pair& pair : detector.inside(side, moved, reach)) confirmed[pair.slave] = 1;
          for (const std::int32_t node : side.nodes()) {
            const Vector3 p = moved.row(node);
            const bool in = in_tissue(moved, cells[second ? 0 : 1], p);
            inside += in;
            missed += in && !confirmed[node] && distance(moved, other.triangles(), p) > 1e-6;
            if (in || !confirmed[node]) continue;
            const Vector3 offset = detector.pair(node, moved).offset(moved);
            wrong += distance_to_rim(moved, other.triangles(), p - offset) >= offset.norm();
          }
        }
      }
    }
  CHECK(inside > 1000);
  CHECK(missed == 0);
  CHECK(wrong == 0);
}

// Thrown at 0.8 of the wave speed, bodies dent each other by more than an edge. A search for the closest point
// that descends from triangle to triangle then ends on a far side of the body, two edges away: 8 of 60 such pairs
// of bodies passed nodes up to 0.25 edges deep, for up to 46 steps.
TEST_CASE(
    "convex bodies that dent each other deeply: no node is deeper in the other's tissue than the deepest gap") {
  for (const unsigned seed : scenes::cases({3u, 10u, 16u})) {
    CAPTURE(seed);
    std::array<Cells, 2> cells;
    const Scene scene = convex::thrown(seed, 4.0, cells);
    Simulation simulation(scene, options(HilberHughesTaylor{}, 5e-5, 1e-10));
    const Detector& detector = simulation.collision()->detector();
    int dented = 0, missed = 0;
    for (int k = 0; k < 110; ++k) {
      simulation.advance();
      if (simulation.record().inverted_tissue > 0) break;  // what lies in a folded cell is anyone's guess
      const Points x = simulation.positions();
      dented += simulation.record().contact->rows > 4;
      for (const bool second : {false, true})
        for (const std::int32_t node : (second ? detector.second() : detector.first()).nodes())
          if (in_tissue(x, cells[second ? 0 : 1], x.row(node)))
            missed += distance(x, (second ? detector.first() : detector.second()).triangles(), x.row(node)) >
                      1e-3 * detector.mean_edge() - simulation.record().contact->deepest_gap;
    }
    CHECK(dented > 20);
    CHECK(missed == 0);
  }
}

TEST_CASE("a node is as deep in the other's tissue as it was pushed, of linear and of quadratic cells") {
  for (const bool quadratic : {false, true})
    for (const double push : {-0.1, 1e-7, 0.11, 0.4}) {
      CAPTURE(quadratic);
      CAPTURE(push);
      const TetMesh a = block_mesh({{-1, 0, 0}, {1, 1, 1}, {3, 2, 2}}),
                    b = block_mesh({{0, -0.4, -0.4}, {1, 2, 2}, {3, 3, 4}});
      TetMesh mesh = combine_meshes(a, b, "a.", "b.");
      if (quadratic) mesh = to_quadratic(mesh);
      const Detector touching(
          {flat_triangles(mesh.surface("a.x_max")), flat_triangles(mesh.surface("b.x_min")), {}}, mesh.points);
      Detector detector = touching;
      Points x = mesh.points;
      const Indices body = body_of_nodes(mesh);
      for (std::ptrdiff_t i = 0; i < x.rows(); ++i)
        if (body[i] == body[0]) x.row(i) += Eigen::RowVector3d(push, 0.013, 0.017);
      detector.update(x);
      CHECK(TissueOverlap(mesh.cells, detector, mesh.points).depth(x, detector) ==
            approx(std::max(0.0, push)).epsilon(1e-12));
    }
}

// Eight linear cells of a strongly curved one may be turned inside out where the curved one is not.
TEST_CASE("a larynx at rest overlaps nowhere, and a fold that is pushed through the other does") {
  const TetMesh mesh = quadratic_larynx_mesh(Larynx::finest());
  Detector detector(
      {flat_triangles(mesh.surface("airway_left")), flat_triangles(mesh.surface("airway_right")), {}},
      mesh.points);
  const TissueOverlap overlap(mesh.cells, detector, mesh.points);
  detector.update(mesh.points);
  CHECK(overlap.depth(mesh.points, detector) == 0);
  for (const double push : {0.2e-3, 0.6e-3}) {  // each fold in x; they are 0.5 mm apart at y = 0
    Points x = mesh.points;
    for (std::ptrdiff_t i = 0; i < x.rows(); ++i) {
      const double along = x(i, 1) / Larynx{}.shape.major;
      if (std::abs(along) < 1) x(i, 0) -= std::copysign(push * (1 - along * along), x(i, 0));
    }
    detector.update(x);
    const double depth = overlap.depth(x, detector);
    if (push < 0.25e-3)
      CHECK(depth == 0);
    else
      CHECK(depth == approx(2 * (push - 0.25e-3)).epsilon(0.2));
  }
}

// A matched airway joins what faced each other at rest. At 1.5 edges of sliding none of its tetrahedra names a
// node 0.01 edges inside.
TEST_CASE("sliding cubes in a matched airway: the deepest gap tells of a node that the airway does not name") {
  Scene scene = scenes::two_cubes(Multipliers{}, 0.0, 3);
  scene.loads = {{"a.x_max", {0, 2.5e3, 2e3}, 0, 0}, {"b.x_min", {0, -2e3, 0}, 0, 0}};
  const auto half = scene.mesh.cell_count() / 2;
  const std::array<Cells, 2> cells{scene.mesh.cells.topRows(half), scene.mesh.cells.bottomRows(half)};
  Simulation simulation(scene, options(HilberHughesTaylor{}, 5e-5, 1e-9));
  Detector& detector = const_cast<Detector&>(simulation.collision()->detector());
  int unnamed = 0;
  for (int k = 0; k < 80; ++k) {
    simulation.advance();
    const Points x = simulation.positions();
    double deepest = 0;
    for (const bool second : {false, true})
      for (const std::int32_t node : (second ? detector.second() : detector.first()).nodes())
        if (in_tissue(x, cells[second ? 0 : 1], x.row(node)))
          deepest = std::max(
              deepest, distance(x, (second ? detector.first() : detector.second()).triangles(), x.row(node)));
    CHECK(simulation.record().contact->deepest_gap <= 1e-6 * detector.mean_edge() - deepest);
    unnamed += deepest > 1e-5 * detector.mean_edge() - detector.deepest(x, deepest * 2).gap;
  }
  CHECK(unnamed > 0);
}

TEST_CASE("bodies that overlap at the start are refused, however deep") {
  for (const double overlap : {1e-4, 3e-3, 8e-3}) {
    Scene scene = sliding(Multipliers{});
    const auto of_b = scene.mesh.node_set("b.x_min")[0];
    scene.mesh.points.bottomRows(scene.mesh.node_count() - of_b).col(0).array() -= 1e-4 + overlap;
    CHECK_THROWS_WITH_AS(Simulation(triangulated(scene), options(HilberHughesTaylor{}, 5e-5)),
                         doctest::Contains("lies in the tissue; must be outside at t = 0"), InvalidInput);
  }
}

TEST_CASE("bodies that touch node on node do not overlap, and do once pushed into each other") {
  for (const int n : {1, 3}) {
    CAPTURE(n);
    const TetMesh a = block_mesh({{-1, 0, 0}, {1, 1, 1}, {n, n, n}}),
                  b = block_mesh({{0, 0, 0}, {1, 1, 1}, {n, n, n}});
    const TetMesh mesh = combine_meshes(a, b, "a.", "b.");
    Points x = mesh.points;
    CHECK_FALSE(node_in_tissue(x, mesh.cells, mesh.node_set("a.x_max"), 1e-6));
    CHECK_FALSE(node_in_tissue(x, mesh.cells, mesh.node_set("b.x_min"), 1e-6));
    // Into it and off its sides, so that nodes lie inside and not on a face of it.
    x.bottomRows(b.node_count()).rowwise() += Eigen::RowVector3d(-0.11, 0.013, 0.017);
    CHECK(node_in_tissue(x, mesh.cells, mesh.node_set("b.x_min"), 1e-6).has_value());
  }
}

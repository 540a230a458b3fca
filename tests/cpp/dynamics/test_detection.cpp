// A second algorithm for detection: every node of one side against every tissue cell of the other body, without
// the airway. Over a whole run it must name the nodes that the detector confirms.
#include <doctest/doctest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

/// Whether p lies in one of the linear cells at positions x; a face between two cells belongs to both.
bool in_tissue(const Points& x, const Cells& cells, const Vector3& p) {
  constexpr double slack = 1e-9;  // of barycentric coordinates, for points on such a face
  for (const auto& cell : cells.rowwise()) {
    const Vector3 origin = x.row(cell[0]);
    Matrix3 edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = x.row(cell[k + 1]).transpose() - origin;
    const Vector3 weights = edges.inverse() * (p - origin);
    if (weights.minCoeff() >= -slack && weights.sum() <= 1 + slack) return true;
  }
  return false;
}

double distance(const Points& x, const Triangles& surface, const Vector3& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& t : surface.rowwise()) {
    const Vector3 a = x.row(t[0]), b = x.row(t[1]), c = x.row(t[2]), w = closest_weights(p, a, b, c);
    least = std::min(least, (p - w[0] * a - w[1] * b - w[2] * c).norm());
  }
  return least;
}

/// Distance of a point to the open border of a surface, where its tissue turns away from the other body.
double distance_to_rim(const Points& x, const Triangles& surface, const Vector3& p) {
  std::map<std::array<std::int32_t, 2>, int> faces;
  for (const auto& t : surface.rowwise())
    for (int k = 0; k < 3; ++k) ++faces[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [edge, count] : faces) {
    if (count > 1) continue;
    const Vector3 a = x.row(edge[0]), along = x.row(edge[1]).transpose() - a;
    const double t = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (p - a - t * along).norm());
  }
  return least;
}

struct Agreement {
  int steps = 0;   // with a node inside
  int inside = 0;  // nodes in the other body's tissue, over all steps
  int missed = 0;  // of these, not confirmed
  int beside = 0;  // confirmed, not in the tissue, their foot nearer to the rim of the surface than to them
  int wrong = 0;   // confirmed, not in the tissue, their foot elsewhere
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
    detector.forget();
    detector.update(x);
    const double reach = detector.reach(before, x, depth);
    const int inside_before = found.inside;
    for (const bool second : {false, true}) {
      const ContactSurface& side = second ? detector.second() : detector.first();
      const ContactSurface& other = second ? detector.first() : detector.second();
      const auto candidates = detector.candidates(side);
      for (const std::int32_t node : side.nodes()) {
        if (other.contains(node)) continue;
        const Vector3 p = x.row(node);
        const bool inside = in_tissue(x, cells[second ? 0 : 1], p);
        const bool candidate = std::binary_search(candidates.begin(), candidates.end(), node);
        if (!inside && !candidate) continue;
        if (distance(x, other.triangles(), p) <= shallow) continue;
        const Pair pair = detector.pair(node, x);
        const bool confirmed = candidate && pair.penetrates(x, reach);
        found.inside += inside;
        found.missed += inside && !confirmed;
        if (!confirmed || inside) continue;
        const Vector3 offset = pair.offset(x);
        const bool at_rim = distance_to_rim(x, other.triangles(), p - offset) < offset.norm();
        ++(at_rim ? found.beside : found.wrong);
      }
    }
    found.steps += found.inside > inside_before;
  }
  return found;
}

/// The coarse larynx in the thesis's tissue with 0.35 of its viscosity, its folds thrown apart or (< 0) together.
Scene larynx(double opening_velocity, double pressure) {
  const Larynx shape = Larynx::coarse();
  TetMesh mesh = larynx_mesh(shape);
  Supports supports(mesh.node_count());
  for (const auto node : mesh.node_set("wall")) supports.fix(node);
  Tissue tissue{{}, mesh.layer_names, mesh.cell_layer};
  const auto material = [](double E, double nu, double E_fibre, double mu_fibre, double viscosity) {
    return Material{TransverselyIsotropic{E, nu, E_fibre, nu, mu_fibre, {}, Vector3::UnitY()}, 1020.0, viscosity};
  };
  for (const std::string& layer : mesh.layer_names)
    tissue.materials.push_back(layer == "cover"      ? material(1e3, 0.66, 10e3, 10e3, 0.14)
                               : layer == "ligament" ? material(3e3, 0.58, 20e3, 40e3, 0.35)
                                                     : material(20e3, 0.45, 40e3, 30e3, 0.35));
  Points velocity = Points::Zero(mesh.node_count(), 3);
  for (std::ptrdiff_t i = 0; i < velocity.rows(); ++i) {
    const double across = std::min(std::abs(mesh.points(i, 1)) / shape.major, 1.0), up = mesh.points(i, 2) / 2e-3;
    velocity(i, 0) = (mesh.points(i, 0) < 0 ? -1 : 1) * opening_velocity * std::cos(std::acos(-1.0) / 2 * across) *
                     std::exp(-up * up);
  }
  AirflowPart airflow;
  airflow.flow.subglottal_pressure = pressure;
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
  for (const Run& run : {Run{1.0, 800, 65}, Run{-1.0, 1200, 75}}) {  // two collisions each
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

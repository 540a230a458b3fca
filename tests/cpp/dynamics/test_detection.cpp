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

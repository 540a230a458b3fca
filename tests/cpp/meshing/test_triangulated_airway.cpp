#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "../approx.hpp"
#include "plica/contact/pairs.hpp"
#include "plica/core/error.hpp"
#include "plica/mesh/larynx.hpp"
#include "plica/meshing/triangulated_airway.hpp"

using namespace plica;

namespace {

struct Gap {
  Points points;
  Triangles first, second;
};

/// An n x n grid over the unit square of (y, z) at x = at, its triangles facing +x or (< 0) -x.
void add_grid(Gap& gap, int n, double at, double facing) {
  const auto offset = static_cast<std::int32_t>(gap.points.rows());
  gap.points.conservativeResize(offset + (n + 1) * (n + 1), 3);
  Triangles faces(2 * n * n, 3);
  int f = 0;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const int a = offset + i + j * (n + 1), b = a + 1, c = b + n + 1, d = a + n + 1;
      gap.points.row(a) << at, double(i) / n, double(j) / n;
      if (i == n || j == n) continue;
      faces.row(f++) << a, b, c;
      faces.row(f++) << a, c, d;
    }
  if (facing < 0) faces.col(1).swap(faces.col(2));
  (facing > 0 ? gap.first : gap.second) = faces;
}

/// Two grids that do not match, `width` apart.
Gap grids(int n, int m, double width) {
  Gap gap;
  gap.points.resize(0, 3);
  add_grid(gap, n, -width / 2, 1);
  add_grid(gap, m, width / 2, -1);
  return gap;
}

}  // namespace

TEST_CASE("the air between flat surfaces that do not match has the volume of the gap, all of it positive") {
  for (const double width : {1.0, 0.1, 1e-3, 1e-9}) {
    CAPTURE(width);
    const Gap gap = grids(3, 5, width);
    const Airway airway = triangulated_airway(gap.points, gap.first, gap.second);
    const Vector volumes = signed_volumes(gap.points, airway.tets);
    CHECK(volumes.minCoeff() >= -1e-15 * width);  // round-off of coordinates near 1
    CHECK(volumes.sum() == approx(width).epsilon(1e-12));
  }
}

TEST_CASE("every tetrahedron of air has nodes of both surfaces, and every node of a flat gap has air") {
  const Gap gap = grids(4, 7, 0.2);
  const Airway airway = triangulated_airway(gap.points, gap.first, gap.second);
  const ContactSurface first(gap.first, gap.points.rows());
  std::vector<int> uses(static_cast<std::size_t>(gap.points.rows()), 0);
  for (const auto& tet : airway.tets.rowwise()) {
    int of_first = 0;
    for (const auto node : tet) {
      of_first += first.contains(node);
      ++uses[static_cast<std::size_t>(node)];
    }
    CHECK(of_first > 0);
    CHECK(of_first < 4);
  }
  for (const int count : uses) CHECK(count > 0);
}

TEST_CASE("surfaces that touch everywhere still have air, which opens and turns inside out with their gap") {
  Gap gap = grids(3, 4, 0.0);
  const Airway airway = triangulated_airway(gap.points, gap.first, gap.second);
  CHECK(airway.tets.rows() > 0);
  CHECK(find_inverted(gap.points, airway.tets).empty());
  Points x = gap.points;
  for (const auto node : gap.second.reshaped()) x(node, 0) = 1e-9;
  CHECK(find_inverted(x, airway.tets).empty());
  CHECK(signed_volumes(x, airway.tets).sum() == approx(1e-9));
  for (const auto node : gap.second.reshaped()) x(node, 0) = -1e-9;
  CHECK(signed_volumes(x, airway.tets).sum() == approx(-1e-9));
}

TEST_CASE("surfaces inside each other by the stated depth have air that is inside out") {
  const double depth = 0.3;  // more than an edge
  Gap gap = grids(4, 5, -depth);
  Airway airway = triangulated_airway(grids(4, 5, 0.0).points, gap.first, gap.second);
  ContactSurface first(gap.first, gap.points.rows()), second(gap.second, gap.points.rows());
  first.update(gap.points);
  second.update(gap.points);
  airway.tets = airway.renewed(gap.points, first, second, depth);
  CHECK(signed_volumes(gap.points, airway.tets).sum() == approx(-depth));
}

TEST_CASE(
    "in the larynx, whose folds share the nodes of the tips, nothing penetrates at rest, however far it reaches") {
  for (const Larynx& larynx : {Larynx::thesis_coarse(), Larynx::thesis_medium()}) {
    const TetMesh mesh = larynx_mesh(larynx);
    Detector detector(triangulated_airway(mesh.points, mesh.surface("airway_left"), mesh.surface("airway_right")),
                      mesh.points);
    detector.update(mesh.points);
    CHECK(detector.candidates(detector.first()).size() > 10);
    CHECK(detector.inside(detector.first(), mesh.points, 1.0).empty());
    CHECK(detector.inside(detector.second(), mesh.points, 1.0).empty());
  }
}

TEST_CASE("the same positions give the same tetrahedra") {
  const TetMesh mesh = larynx_mesh(Larynx::thesis_coarse());
  const Triangles left = mesh.surface("airway_left"), right = mesh.surface("airway_right");
  const Tets once = triangulated_airway(mesh.points, left, right).tets;
  CHECK(once == triangulated_airway(mesh.points, left, right).tets);
}

TEST_CASE("empty surfaces, positions that are not finite and surfaces without air between them are refused") {
  Gap gap = grids(2, 3, 0.1);
  CHECK_THROWS_AS(triangulated_airway(gap.points, Triangles(0, 3), gap.second), InvalidInput);
  Gap away = grids(2, 3, 2.0);  // back to back
  away.first.col(1).swap(away.first.col(2));
  away.second.col(1).swap(away.second.col(2));
  CHECK_THROWS_WITH_AS(triangulated_airway(away.points, away.first, away.second),
                       doctest::Contains("face each other"), InvalidInput);
  gap.points(4, 1) = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH_AS(triangulated_airway(gap.points, gap.first, gap.second), doctest::Contains("node 4"),
                       InvalidInput);
}

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "../approx.hpp"
#include "plica/contact/surface.hpp"
#include "plica/core/error.hpp"
#include "plica/mesh/block.hpp"

using namespace plica;

namespace {

/// A second algorithm: the triangle is sampled finer and finer around the best sample. Distances are convex over
/// the triangle, so the best cell of a coarse net and its neighbours hold the closest point.
double sampled_distance(const Vector3& p, const Vector3& a, const Vector3& b, const Vector3& c) {
  double u0 = 0, v0 = 0, width = 1, best = 1e300;
  for (int level = 0; level < 40; ++level) {
    double u_best = u0, v_best = v0;
    for (int i = -4; i <= 4; ++i)
      for (int j = -4; j <= 4; ++j) {
        const double u = std::max(0.0, u0 + width * i / 4), v = std::max(0.0, v0 + width * j / 4);
        const double sum = std::max(1.0, u + v);
        const double d = (p - a - u / sum * (b - a) - v / sum * (c - a)).norm();
        if (d < best) best = d, u_best = u / sum, v_best = v / sum;
      }
    u0 = u_best, v0 = v_best;
    width *= 0.6;
  }
  return best;
}

/// A bumpy n x n sheet over the unit square of (x, y), outward +z.
struct Sheet {
  Points points;
  Triangles triangles;
};
Sheet bumpy_sheet(int n) {
  Sheet sheet;
  sheet.points.resize((n + 1) * (n + 1), 3);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double x = double(i) / n, y = double(j) / n;
      sheet.points.row(i + j * (n + 1)) << x, y, 0.1 * std::sin(3 * x) * std::cos(2 * y);
    }
  sheet.triangles.resize(2 * n * n, 3);
  int f = 0;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = i + j * (n + 1), b = a + 1, c = b + n + 1, d = a + n + 1;
      sheet.triangles.row(f++) << a, b, c;
      sheet.triangles.row(f++) << a, c, d;
    }
  return sheet;
}

}  // namespace

TEST_CASE("the closest point of a triangle is the one that sampling finds") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto point = [&] { return Vector3(uniform(random), uniform(random), uniform(random)); };
  for (int k = 0; k < 300; ++k) {
    const Vector3 a = point(), b = point(), c = point(), p = 2 * point();
    if ((b - a).cross(c - a).norm() < 0.05) continue;
    const Vector3 w = closest_weights(p, a, b, c);
    CHECK(w.minCoeff() >= 0);
    CHECK(w.sum() == approx(1).epsilon(1e-12));
    const double distance = (p - w[0] * a - w[1] * b - w[2] * c).norm();
    CHECK(distance <= sampled_distance(p, a, b, c) + 1e-12);  // no sample is closer
  }
}

TEST_CASE("a point of the triangle is its own closest point") {
  const Vector3 a(0, 0, 0), b(2, 0, 1), c(0, 1, -1);
  for (const Vector3& w : {Vector3(0.2, 0.3, 0.5), Vector3(1, 0, 0), Vector3(0, 0.5, 0.5), Vector3(0, 0, 1)})
    CHECK((closest_weights(w[0] * a + w[1] * b + w[2] * c, a, b, c) - w).norm() < 1e-14);
}

TEST_CASE(
    "the closest point is that of the closest triangle of all: of a bumpy sheet, and inside a closed surface") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto compare = [&](const Points& x, const Triangles& triangles, const auto& draw) {
    ContactSurface surface(triangles, x.rows());
    surface.update(0.5 * x);
    surface.update(x);
    for (int k = 0; k < 200; ++k) {
      const Vector3 p = draw();
      double best = 1e300;
      for (const auto& t : triangles.rowwise()) {
        const Vector3 a = x.row(t[0]), b = x.row(t[1]), c = x.row(t[2]), w = closest_weights(p, a, b, c);
        best = std::min(best, (p - w[0] * a - w[1] * b - w[2] * c).squaredNorm());
      }
      CHECK(surface.closest(x, p).squared_distance == approx(best).epsilon(1e-12));
    }
  };
  const Sheet sheet = bumpy_sheet(12);
  compare(sheet.points, sheet.triangles,
          [&] { return Vector3(uniform(random), uniform(random), 0.1 * uniform(random) - 0.05); });
  // From a point inside, every face of a box is at a least distance of its own.
  const TetMesh box = block_mesh({{0, 0, 0}, {1, 1, 1}, {4, 5, 6}});
  compare(box.points, boundary_of(box.cells).faces,
          [&] { return Vector3(uniform(random), uniform(random), uniform(random)); });
}

TEST_CASE("tributary areas add up to the surface and normals are the plane's") {
  Sheet sheet = bumpy_sheet(4);
  sheet.points.col(2) = 0.5 * sheet.points.col(0);  // the plane z = x / 2
  ContactSurface surface(sheet.triangles, sheet.points.rows());
  surface.update(sheet.points);
  double area = 0;
  for (const auto node : surface.nodes()) {
    area += surface.tributary_area(node);
    CHECK((surface.normal(node) - Vector3(-0.5, 0, 1).normalized()).norm() < 1e-14);
  }
  CHECK(area == approx(std::sqrt(1.25)).epsilon(1e-13));
}

TEST_CASE(
    "the foot is the same whatever triangle is looked at first: of equally near ones the first, no hidden one") {
  const Sheet sheet = bumpy_sheet(1);  // two triangles and the diagonal between them
  ContactSurface surface(sheet.triangles, sheet.points.rows());
  surface.update(sheet.points);
  const Vector3 on_diagonal = 0.5 * (sheet.points.row(0) + sheet.points.row(3));
  for (const std::int32_t near : {-1, 0, 1}) CHECK(surface.closest(sheet.points, on_diagonal, near).triangle == 0);
  const Vector3 on_second = (sheet.points.row(0) + sheet.points.row(3) + sheet.points.row(2)) / 3.0;
  CHECK(surface.closest(sheet.points, on_second, 0).triangle == 1);
  surface.look_at({0});
  surface.update(sheet.points);
  for (const std::int32_t near : {-1, 0, 1}) CHECK(surface.closest(sheet.points, on_second, near).triangle == 0);
}

TEST_CASE("a surface without triangles is refused") {
  CHECK_THROWS_AS(ContactSurface(Triangles(0, 3), 4), InvalidInput);
}

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "../approx.hpp"
#include "plica/contact/triangle_overlap.hpp"

using namespace plica;

namespace {

using Place = Eigen::Vector2d;
using Seen = std::array<Place, 3>;

double area(const std::vector<TrianglePoint>& points) {
  double sum = 0;
  for (const auto& point : points) sum += point.weight;
  return sum;
}

}  // namespace

TEST_CASE("points over a whole triangle integrate polynomials of degree four exactly") {
  const auto points = overlap_points(Seen{Place(0, 0), Place(0, 1), Place(1, 0)});
  REQUIRE(points.size() == 6);
  for (int m = 0; m <= 4; ++m)
    for (int n = 0; m + n <= 4; ++n) {
      double sum = 0;
      for (const auto& [place, weight] : points) sum += weight * std::pow(place[0], m) * std::pow(place[1], n);
      CHECK(sum == approx(std::tgamma(m + 1) * std::tgamma(n + 1) / std::tgamma(m + n + 3)).epsilon(1e-13));
    }
}

TEST_CASE("points lie in both triangles, and their weights are the shared area") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> at(-0.5, 1.5);
  int shared = 0;
  for (int trial = 0; trial < 200; ++trial) {
    Seen other{Place(at(random), at(random)), Place(at(random), at(random)), Place(at(random), at(random))};
    Eigen::Matrix2d sides;
    sides << other[1] - other[0], other[2] - other[0];
    if (sides.determinant() > 0) std::swap(other[1], other[2]);
    sides << other[1] - other[0], other[2] - other[0];
    const auto points = overlap_points(other);
    for (const auto& [place, weight] : points) {
      const Place in_other = sides.inverse() * (place - other[0]);
      CHECK(std::min({place.minCoeff(), 1 - place.sum(), in_other.minCoeff(), 1 - in_other.sum()}) > 0);
      CHECK(weight > 0);
    }
    // By counting the cells of a fine grid over the triangle.
    constexpr int n = 400;
    int inside = 0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const Place in_other = sides.inverse() * (Place((i + 1.0 / 3) / n, (j + 1.0 / 3) / n) - other[0]);
        inside += in_other.minCoeff() > 0 && in_other.sum() < 1;
      }
    CHECK(area(points) == approx(inside * 1.0 / (n * n)).epsilon(0.02).scale(0.1));
    shared += area(points) > 0.01;
  }
  CHECK(shared > 50);
}

TEST_CASE("a triangle of the same sense, beside, or sharing an edge alone has no points") {
  CHECK(overlap_points(Seen{Place(0, 0), Place(1, 0), Place(0, 1)}).empty());
  CHECK(overlap_points(Seen{Place(2, 0), Place(2, 1), Place(3, 0)}).empty());
  CHECK(overlap_points(Seen{Place(1, 0), Place(0, 1), Place(1, 1)}).empty());
  CHECK(overlap_points(Seen{Place(0, 0), Place(1, 0), Place(0.5, -1)}).empty());
  CHECK(overlap_points(Seen{Place(0, 0), Place(0, 0), Place(0, 0)}).empty());
}

TEST_CASE("a triangle is seen along the other's normal") {
  const std::array<Vector3, 3> from{Vector3(1, 0, 0), Vector3(3, 0, 1), Vector3(1, 2, 0)};
  const Vector3 u = from[1] - from[0], v = from[2] - from[0], n = u.cross(v);
  const std::array<Vector3, 3> other{from[0] + 0.3 * u + 0.4 * v + 7 * n, from[0] - u + 2 * v, from[0] - 0.1 * n};
  const Seen seen = seen_from(from, other);
  CHECK((seen[0] - Place(0.3, 0.4)).norm() < 1e-14);
  CHECK((seen[1] - Place(-1, 2)).norm() < 1e-14);
  CHECK(seen[2].norm() < 1e-14);
}

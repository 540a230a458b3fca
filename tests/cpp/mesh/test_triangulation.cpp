#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "../approx.hpp"
#include "plica/core/error.hpp"
#include "plica/mesh/triangulation.hpp"

using namespace plica;

namespace {

using Point = Eigen::Vector2d;

double twice_area(const Triangulation& t, const std::array<std::int32_t, 3>& c) {
  const Point a = t.points[c[1]] - t.points[c[0]], b = t.points[c[2]] - t.points[c[0]];
  return a[0] * b[1] - a[1] * b[0];
}

double area(const Triangulation& t) {
  double sum = 0;
  for (const auto& c : t.triangles) sum += 0.5 * twice_area(t, c);
  return sum;
}

/// An L of area 3 with a line into its notch.
Outline notched(double size) {
  Outline outline;
  const std::vector<Point> corners = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}, {0, 0}};
  const auto point = [&](const Point& p) {
    const auto place = std::find(outline.points.begin(), outline.points.end(), p) - outline.points.begin();
    if (place == static_cast<std::ptrdiff_t>(outline.points.size())) outline.points.push_back(p);
    return static_cast<std::int32_t>(place);
  };
  const auto line = [&](const Point& a, const Point& b) {
    const int pieces = static_cast<int>(std::round((b - a).norm() / size));
    std::vector<std::int32_t> nodes;
    for (int i = 0; i <= pieces; ++i) nodes.push_back(point(a + (b - a) * i / pieces));
    outline.lines.push_back(nodes);
  };
  for (std::size_t k = 0; k + 1 < corners.size(); ++k) line(corners[k], corners[k + 1]);
  line({1, 1}, {0, 0});
  outline.inside = [](const Point& p) {
    return p[0] > 0 && p[1] > 0 && p[0] < 2 && p[1] < 2 && (p[0] < 1 || p[1] < 1);
  };
  outline.size = [size](const Point&) { return size; };
  return outline;
}

}  // namespace

TEST_CASE("a notched outline is filled by positive triangles that hold its lines") {
  const Outline outline = notched(0.25);
  const Triangulation made = triangulate(outline);
  CHECK(area(made) == approx(3).epsilon(1e-12));
  std::set<Edge> edges;
  double least = 1;
  for (const auto& c : made.triangles) {
    least = std::min(least, twice_area(made, c));
    for (int k = 0; k < 3; ++k) edges.insert(edge(c[k], c[(k + 1) % 3]));
  }
  CHECK(least > 0.01);
  for (const auto& line : outline.lines)
    for (std::size_t i = 0; i + 1 < line.size(); ++i) CHECK(edges.count(edge(line[i], line[i + 1])) == 1);
  for (std::size_t i = 0; i < outline.points.size(); ++i) CHECK(made.points[i] == outline.points[i]);
  // Euler: V - E + F = 1 for a disc.
  CHECK(static_cast<long>(made.points.size()) - static_cast<long>(edges.size()) +
            static_cast<long>(made.triangles.size()) ==
        1);
}

TEST_CASE("triangles are as small as wanted and not much smaller") {
  for (const double size : {0.5, 0.25, 0.125}) {
    const double count = static_cast<double>(triangulate(notched(size)).triangles.size());
    CHECK(count > 3 / (0.5 * size * size));          // right ones with two sides of that length
    CHECK(count < 2.0 * 3 / (0.433 * size * size));  // equilateral ones
  }
}

TEST_CASE("no triangle inside the lines could be exchanged for a better one") {
  const Outline outline = notched(0.25);
  const Triangulation made = triangulate(outline);
  std::set<Edge> fixed;
  for (const auto& line : outline.lines)
    for (std::size_t i = 0; i + 1 < line.size(); ++i) fixed.insert(edge(line[i], line[i + 1]));
  for (const auto& t : made.triangles)
    for (const auto& u : made.triangles)
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) {
          if (t[k] != u[(l + 1) % 3] || t[(k + 1) % 3] != u[l] || fixed.count(edge(t[k], u[l]))) continue;
          // Delaunay: the angles opposite to the edge are not more than pi together.
          const auto angle = [&](std::int32_t at, std::int32_t a, std::int32_t b) {
            const Point p = made.points[a] - made.points[at], q = made.points[b] - made.points[at];
            return std::acos(p.dot(q) / p.norm() / q.norm());
          };
          CHECK(angle(t[(k + 2) % 3], t[k], t[(k + 1) % 3]) + angle(u[(l + 2) % 3], u[l], u[(l + 1) % 3]) <
                std::acos(-1.0) + 1e-9);
        }
}

TEST_CASE("lines that cross are refused") {
  Outline outline = notched(1);
  outline.lines.push_back({0, static_cast<std::int32_t>(outline.points.size())});
  outline.points.emplace_back(0.5, 1.5);
  outline.lines.push_back({1, static_cast<std::int32_t>(outline.points.size()) - 1});
  outline.lines.push_back({static_cast<std::int32_t>(outline.points.size()) - 1, 2});
  CHECK_THROWS_AS(triangulate(outline), InvalidInput);
}

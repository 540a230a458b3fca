#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "../approx.hpp"
#include "plica/airflow/sections.hpp"
#include "plica/core/error.hpp"
#include "tube.hpp"

using namespace plica;

namespace {

const std::vector<double> heights{-2, -1, -0.25, 0.5, 1};
double cone(double z) { return 0.5 + 0.125 * z; }

/// x of the right and of the left point of each section, at positions x.
Eigen::Matrix<double, Eigen::Dynamic, 2> edges(const Sections& sections, const Points& x) {
  Eigen::Matrix<double, Eigen::Dynamic, 2> found(sections.count(), 2);
  for (std::ptrdiff_t i = 0; i < sections.count(); ++i)
    found.row(i) << sections.right[i].at(x)[0], sections.left[i].at(x)[0];
  return found;
}

std::string message_of(const TetMesh& mesh) {
  try {
    level_sections(mesh, mesh.surface("airway"));
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("nodes on the mid-coronal plane are the sections, one on each side") {
  const TetMesh mesh = tube(12, heights, cone, 0.7);
  const Sections sections = level_sections(mesh, mesh.surface("airway"));
  REQUIRE(sections.count() == 5);
  for (int i = 0; i < 5; ++i) {
    CHECK(sections.height[i] == heights[i]);
    CHECK(sections.right[i].nodes == std::vector<std::int32_t>{12 * i});
    CHECK(sections.left[i].nodes == std::vector<std::int32_t>{12 * i + 6});
    CHECK(sections.right[i].weights[0] == 1);
    CHECK(sections.major[i] == approx(0.7).epsilon(1e-15));  // 3 of 12 steps: the tip is a node
  }
}

TEST_CASE("where no node lies at y = 0 the sections are the exact cut of the tube") {
  const int around = 10;
  const TetMesh mesh = tube(around, heights, cone, 0.7, 0.5);
  const Sections sections = level_sections(mesh, mesh.surface("airway"));
  CHECK(sections.count() == 9);  // five rings, and the diagonals between them
  const auto at_rest = edges(sections, mesh.points);
  const double inner = std::cos(std::acos(-1.0) / around);  // the edges next to y = 0 have this x for minor = 1
  for (int i = 0; i < sections.count(); ++i) {
    CHECK(at_rest(i, 0) == approx(inner * cone(sections.height[i])).epsilon(1e-14));
    CHECK(at_rest(i, 1) == approx(-inner * cone(sections.height[i])).epsilon(1e-14));
    for (const auto* point : {&sections.right[i], &sections.left[i]}) {
      const Vector3 at = point->at(mesh.points);
      CHECK(std::abs(at[1]) < 1e-15);
      CHECK(at[2] == approx(sections.height[i]).epsilon(1e-14));
      CHECK(point->nodes.size() <= 4);
    }
  }
}

TEST_CASE("folds with different levels share the union of their heights") {
  TetMesh mesh = tube(12, heights, cone, 0.7);
  Faces& wall = mesh.surfaces["airway"];
  const TetMesh other = tube(12, {-1.5, 0, 0.5 + 1e-7, 2}, cone, 0.7);
  const std::int32_t shift = static_cast<std::int32_t>(mesh.points.rows());
  Points points(mesh.points.rows() + other.points.rows(), 3);
  points << mesh.points, other.points;
  std::vector<std::int32_t> faces;  // right half of one, left half of the other
  const auto keep = [&](const TetMesh& from, double side, std::int32_t by) {
    for (const auto& t : from.surface("airway").rowwise())
      if (side * (from.points(t[0], 0) + from.points(t[1], 0) + from.points(t[2], 0)) > 0)
        for (const auto node : t) faces.push_back(node + by);
  };
  keep(mesh, 1, 0);
  keep(other, -1, shift);
  wall = Eigen::Map<const Faces>(faces.data(), static_cast<std::ptrdiff_t>(faces.size()) / 3, 3);
  mesh.points = points;
  const Sections sections = level_sections(mesh, wall);
  const std::vector<double> expected{-1.5, -1, -0.25, 0, 0.5, 1};  // common range; 0.5 and 0.5 + 1e-7 are one
  REQUIRE(sections.count() == 6);
  const auto at_rest = edges(sections, points);
  for (int i = 0; i < 6; ++i) {
    CHECK(sections.height[i] == expected[i]);
    CHECK(at_rest(i, 0) == approx(cone(expected[i])).epsilon(1e-14));
    CHECK(at_rest(i, 1) == approx(-cone(expected[i])).epsilon(1e-6));  // one level is 1e-7 off
  }
}

TEST_CASE("graded sections have the heights of the surface's edges among them, so that no throat is between two") {
  const std::vector<double> heights{-2, -0.7, 0.3, 0.9, 2};
  const auto hourglass = [](double z) { return 0.05 + 0.3 * std::abs(z - 0.3); };
  const TetMesh mesh = tube(12, heights, hourglass, 0.7);
  for (const int count : {12, 25, 40, 83}) {
    const Sections sections = graded_sections(mesh, mesh.surface("airway"), count);
    REQUIRE(sections.count() == count);
    CHECK((sections.height.tail(count - 1) - sections.height.head(count - 1)).minCoeff() > 0);
    for (const double z : {-0.7, 0.3, 0.9}) CHECK((sections.height.array() == z).count() == 1);
    CHECK(sections.widths(mesh.points).minCoeff() == approx(0.1).epsilon(1e-14));
  }
  const Sections few = graded_sections(mesh, mesh.surface("airway"), 2);  // the ends stay
  CHECK(few.height[0] == approx(-2).epsilon(1e-3));
  CHECK(few.height[1] == approx(2).epsilon(1e-3));
}

TEST_CASE("sections follow the tissue as fixed combinations of nodes") {
  const TetMesh mesh = tube(10, heights, cone, 0.7, 0.3);
  const Sections sections = level_sections(mesh, mesh.surface("airway"));
  Points x = mesh.points;
  x.col(0) = 2 * mesh.points.col(0) + 0.1 * mesh.points.col(1) + Vector::Constant(x.rows(), 0.03);
  const auto before = edges(sections, mesh.points), after = edges(sections, x);
  CHECK((after - 2 * before).isConstant(0.03, 1e-14));  // an affine motion is followed exactly
  CHECK((sections.widths(x) - 2 * sections.widths(mesh.points)).norm() < 1e-14);
}

TEST_CASE("a tube that lies elsewhere has the same sections there") {
  const TetMesh mesh = tube(10, heights, cone, 0.7, 0.3);
  const Sections sections = level_sections(mesh, mesh.surface("airway"));
  for (int axis = 0; axis < 3; ++axis)
    for (const double shift : {0.03, -100.0}) {
      TetMesh moved = mesh;
      moved.points.col(axis).array() += shift;
      const Sections there = level_sections(moved, moved.surface("airway"));
      const double round_off = 1e-15 * std::max(1.0, std::abs(shift));
      REQUIRE(there.count() == sections.count());
      CHECK((there.widths(moved.points) - sections.widths(mesh.points)).cwiseAbs().maxCoeff() < 4 * round_off);
      CHECK((there.major - sections.major).cwiseAbs().maxCoeff() < 4 * round_off);
      const double ahead = axis == 1 ? shift : 0, up = axis == 2 ? shift : 0;
      CHECK((there.middle.array() - sections.middle.array() - ahead).abs().maxCoeff() < 4 * round_off);
      CHECK((there.height.array() - sections.height.array() - up).abs().maxCoeff() < 4 * round_off);
      CHECK(there.toward_right == 1);
    }
}

TEST_CASE("folds that touch at rest are told apart by their normals") {
  const TetMesh mesh = tube(
      12, heights, [](double z) { return z == 0.5 ? 0.0 : 0.25; }, 0.7);
  const Sections sections = level_sections(mesh, mesh.surface("airway"));
  REQUIRE(sections.count() == 5);
  CHECK(edges(sections, mesh.points).row(3).norm() < 1e-16);
  CHECK(sections.right[3].nodes[0] == 36);
  CHECK(sections.left[3].nodes[0] == 42);
}

TEST_CASE("an interface that is not one line over the height on each side is refused") {
  TetMesh overhang = tube(12, heights, cone, 0.7);
  overhang.points.block(24, 2, 12, 1).setConstant(0.75);  // the third ring above the fourth
  CHECK(message_of(overhang) != "");
  TetMesh level = tube(12, heights, cone, 0.7);
  level.points.block(24, 2, 12, 1).setConstant(0.5);
  CHECK(message_of(level).find("runs level") != std::string::npos);
  TetMesh half = tube(12, heights, cone, 0.7);
  Faces& wall = half.surfaces["airway"];
  std::ptrdiff_t kept = 0;
  for (std::ptrdiff_t f = 0; f < wall.rows(); ++f)
    if (half.points(wall(f, 0), 0) + half.points(wall(f, 1), 0) + half.points(wall(f, 2), 0) > 0)
      wall.row(kept++) = Faces(wall.row(f));
  wall.conservativeResize(kept, 3);
  CHECK(message_of(half).find("toward smaller x; must cross its mid-coronal plane") != std::string::npos);
  TetMesh inward = tube(12, heights, cone, 0.7);
  inward.surfaces["airway"].col(0).swap(inward.surfaces["airway"].col(1));
  CHECK(message_of(inward).find("outward") != std::string::npos);
}

TEST_CASE("the cut area is that of the polygon, also in a plane through nodes") {
  const TetMesh mesh = tube(12, heights, cone, 0.7);
  const Triangles wall = mesh.surface("airway");
  for (const double z : {-2.0, -1.7, -1.0, -0.25, 0.1, 0.5, 0.9, 1.0})  // both rims and inner rings among them
    // Between rings a panel's two triangles leave its ruled surface: a quarter of the difference of minor
    // half-axes times the difference of cosines along a step, here below 0.4 % of the area.
    CHECK(cut_area(mesh.points, wall, z) == approx(inscribed(12, cone(z), 0.7)).epsilon(0.004));
  for (const double z : heights)
    CHECK(cut_area(mesh.points, wall, z) == approx(inscribed(12, cone(z), 0.7)).epsilon(1e-14));
  CHECK(cut_area(mesh.points, wall, 1.5) == 0);
  CHECK(cut_area(mesh.points, wall, -2.5) == 0);
}

TEST_CASE("planes cut together give the areas of planes cut one by one") {
  const TetMesh mesh = tube(12, heights, cone, 0.7, 0.2);
  const Triangles wall = mesh.surface("airway");
  Vector heights(7);
  heights << -3, -2, -1.1, -0.25, -0.25, 0.7, 1;
  const Vector areas = cut_areas(mesh.points, wall, heights);
  for (int i = 0; i < 7; ++i) CHECK(areas[i] == cut_area(mesh.points, wall, heights[i]));
  CHECK(areas.tail(6).minCoeff() > 0.1);
}

TEST_CASE("a plane near a ring of nodes cuts almost the area of the ring") {
  const TetMesh mesh = tube(12, heights, cone, 0.7);
  const Triangles wall = mesh.surface("airway");
  const double at = cut_area(mesh.points, wall, -0.25);
  for (const double off : {-1e-9, -1e-14, 1e-14, 1e-9})
    CHECK(cut_area(mesh.points, wall, -0.25 + off) == approx(at).epsilon(1e-8));  // its slope is below 1 / m
}

TEST_CASE("moving one half apart changes the cut area by the depth times the way, to negative at overlap") {
  const TetMesh mesh = tube(12, heights, cone, 0.7);
  const Triangles wall = mesh.surface("airway");
  // The halves of a tube cut open at its tips: right half as it is, left half with tips of its own.
  const std::int32_t count = static_cast<std::int32_t>(mesh.points.rows());
  Points points(2 * count, 3);
  points << mesh.points, mesh.points;
  Triangles open = wall;
  for (auto t : open.rowwise())
    if (mesh.points(t[0], 0) + mesh.points(t[1], 0) + mesh.points(t[2], 0) < 0) t.array() += count;
  for (const double way : {-0.2, 0.1, 2.0}) {
    Points x = points;
    x.bottomRows(count).col(0).array() += way;
    const double expected = inscribed(12, cone(0.5), 0.7) - 1.4 * way;
    CHECK(cut_area(x, open, 0.5) == approx(expected).epsilon(1e-13));
    CHECK((expected < 0) == (way == 2.0));
  }
}

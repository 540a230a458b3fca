#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <string>

#include "../approx.hpp"
#include "plica/contact/airway.hpp"
#include "plica/core/error.hpp"
#include "plica/mesh/larynx.hpp"

using namespace plica;

namespace {

struct Gap {
  Points points;
  Triangles first, second;
};

/// Two n x n grids over the unit square of (y, z), facing each other along x: first at -half_gap(y, z) with
/// outward normal +x, second at +half_gap. Nodes of the second have shuffled numbers; where the gap is
/// exactly closed on the edge y = 0 and `share`, both use the node of the first.
template <class HalfGap>
Gap facing_grids(int n, HalfGap half_gap, bool share = false) {
  const int m = (n + 1) * (n + 1);
  std::vector<std::int32_t> second(m);
  for (int i = 0; i < m; ++i) second[i] = m + i;
  std::mt19937 random(3);
  std::shuffle(second.begin(), second.end(), random);
  Gap gap;
  gap.points.resize(2 * m, 3);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double y = double(i) / n, z = double(j) / n, h = half_gap(y, z);
      const int node = i + j * (n + 1);
      gap.points.row(node) << -h, y, z;
      gap.points.row(second[node]) << h, y, z;
      if (share && i == 0) second[node] = node;
    }
  gap.first.resize(2 * n * n, 3);
  gap.second.resize(2 * n * n, 3);
  int f = 0;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = i + j * (n + 1), b = a + 1, c = b + n + 1, d = a + n + 1;
      std::array<std::array<int, 3>, 2> cut{{{a, b, c}, {a, c, d}}};
      if ((i + j) % 2) cut = {{{a, b, d}, {b, c, d}}};
      for (const auto& t : cut) {
        gap.first.row(f) << t[0], t[1], t[2];
        gap.second.row(f) << second[t[2]], second[t[1]], second[t[0]];
        ++f;
      }
    }
  std::reverse(gap.second.data(),
               gap.second.data() + gap.second.size());  // order and start of the rows do not matter
  for (int t = 0; t < f; ++t) std::swap(gap.second(t, 0), gap.second(t, 2));
  return gap;
}

double wavy(double y, double z) { return 0.1 + 0.05 * std::sin(5 * y + 2 * z) + 0.03 * y * z; }

using Face = std::set<std::int32_t>;
std::map<Face, int> face_counts(const Tets& tets) {
  std::map<Face, int> count;
  for (const auto& t : tets.rowwise()) {
    ++count[{t[0], t[1], t[2]}];
    ++count[{t[0], t[1], t[3]}];
    ++count[{t[0], t[2], t[3]}];
    ++count[{t[1], t[2], t[3]}];
  }
  return count;
}

/// Integral of the piecewise linear gap over the triangles of (y, z), by its nodal values.
double gap_volume(const Gap& gap) {
  double volume = 0;
  std::map<std::pair<double, double>, double> far;
  for (const auto& t : gap.second.rowwise())
    for (const auto node : t) far[{gap.points(node, 1), gap.points(node, 2)}] = gap.points(node, 0);
  for (const auto& t : gap.first.rowwise()) {
    const Vector3 e = gap.points.row(t[1]) - gap.points.row(t[0]), g = gap.points.row(t[2]) - gap.points.row(t[0]);
    double mean = 0;
    for (const auto node : t)
      mean += (far.at({gap.points(node, 1), gap.points(node, 2)}) - gap.points(node, 0)) / 3;
    volume += mean * (e[1] * g[2] - e[2] * g[1]) / 2;
  }
  return volume;
}

std::string message_of(const Gap& gap, const Vector3& direction = {1, 0, 0}) {
  try {
    matched_airway(gap.points, gap.first, gap.second, direction);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

void check_conforms(const Gap& gap, const Airway& airway) {
  auto count = face_counts(airway.tets);
  for (const auto* surface : {&gap.first, &gap.second})
    for (const auto& t : surface->rowwise()) {
      CHECK(count.at({t[0], t[1], t[2]}) == 1);
      count.erase({t[0], t[1], t[2]});
    }
  for (const auto& [face, shared] : count) {
    const bool on_rim = [&, f = face] {
      for (int axis : {1, 2})
        for (double side : {0.0, 1.0})
          if (std::all_of(f.begin(), f.end(), [&](int n) { return gap.points(n, axis) == side; })) return true;
      return false;
    }();
    CHECK(shared == (on_rim ? 1 : 2));
  }
}

}  // namespace

TEST_CASE("the air between matched surfaces has the volume of the gap and no tetrahedron turned inside out") {
  const Gap gap = facing_grids(5, wavy);
  const Airway airway = matched_airway(gap.points, gap.first, gap.second, {1, 0, 0});
  CHECK(airway.tets.rows() == 3 * gap.first.rows());
  const Vector volumes = signed_volumes(gap.points, airway.tets);
  CHECK(volumes.minCoeff() > 0);
  CHECK(volumes.sum() == approx(gap_volume(gap)).epsilon(1e-13));  // round-off of 150 terms
  CHECK(find_inverted(gap.points, airway.tets).empty());
}

TEST_CASE("air tetrahedra conform and carry each surface triangle once") {
  const Gap gap = facing_grids(4, wavy);
  check_conforms(gap, matched_airway(gap.points, gap.first, gap.second, {1, 0, 0}));
}

TEST_CASE("the sign and length of the direction and the order of the surfaces do not matter") {
  const Gap gap = facing_grids(3, wavy);
  const Tets tets = matched_airway(gap.points, gap.first, gap.second, {1, 0, 0}).tets;
  CHECK(tets == matched_airway(gap.points, gap.first, gap.second, {-0.01, 0, 0}).tets);
  CHECK(find_inverted(gap.points, matched_airway(gap.points, gap.second, gap.first, {1, 0, 0}).tets).empty());
}

TEST_CASE("nodes common to both surfaces close the prisms without flat tetrahedra") {
  const auto wedge = [](double y, double) { return 0.2 * y; };
  const int n = 4;
  const Gap gap = facing_grids(n, wedge, true);
  const Airway airway = matched_airway(gap.points, gap.first, gap.second, {1, 0, 0});
  int shared = 0;  // one tetrahedron is missing for each corner at y = 0
  for (const auto node : gap.first.reshaped()) shared += gap.points(node, 1) == 0;
  CHECK(shared > 0);
  CHECK(airway.tets.rows() == 3 * gap.first.rows() - shared);
  const Vector volumes = signed_volumes(gap.points, airway.tets);
  CHECK(volumes.minCoeff() > 0);
  CHECK(volumes.sum() == approx(0.2).epsilon(1e-13));  // integral of 2 * 0.2 y over the unit square
  check_conforms(gap, airway);
}

TEST_CASE("touching bodies have an airway whose tetrahedra open and close with the sense of the surfaces") {
  Gap gap = facing_grids(3, [](double, double) { return 0.0; });
  const Airway airway = matched_airway(gap.points, gap.first, gap.second, {1, 0, 0});
  CHECK(airway.tets.rows() == 3 * gap.first.rows());
  CHECK(find_inverted(gap.points, airway.tets).empty());
  Points x = gap.points;
  for (const auto node : gap.second.reshaped()) x(node, 0) = 1e-9;
  CHECK(signed_volumes(x, airway.tets).minCoeff() > 0);
  for (const auto node : gap.second.reshaped()) x(node, 0) = -1e-9;
  CHECK(find_inverted(x, airway.tets).size() == static_cast<std::size_t>(airway.tets.rows()));
}

TEST_CASE("a node inverts air exactly when it is pushed through the opposite face") {
  const Gap gap = facing_grids(4, wavy);
  const Airway airway = matched_airway(gap.points, gap.first, gap.second, {1, 0, 0});
  const int node = 2 + 2 * 5;
  int partner = -1;
  for (const auto other : gap.second.reshaped())
    if (gap.points(other, 1) == gap.points(node, 1) && gap.points(other, 2) == gap.points(node, 2))
      partner = other;
  const double opposite = gap.points(partner, 0);
  Points x = gap.points;
  x(node, 0) = opposite;
  CHECK(find_inverted(x, airway.tets).empty());
  x(node, 0) = std::nextafter(opposite, 0.0);
  CHECK(find_inverted(x, airway.tets).empty());
  x(node, 0) = std::nextafter(opposite, 1.0);  // one unit in the last place through it
  const auto through = find_inverted(x, airway.tets);
  CHECK(!through.empty());
  for (const auto t : through) CHECK((airway.tets.row(t).array() == node).any());
}

TEST_CASE("orientation is exact where floating point loses the sign") {
  // Three points of the plane x = z; the fourth lies on it or a few units in the last place off it.
  const double h = 1.0 / 3.0, u = std::nextafter(h, 1.0) - h;
  Points x(4, 3);
  x << 12, 12, 12, 24, 24, 24, h, h + 0.5, h, h, h, h;  // all in the plane x = z: flat
  Tets tet(1, 4);
  tet << 0, 1, 2, 3;
  CHECK(find_inverted(x, tet).empty());
  int disagreements = 0;
  for (int i = -8; i <= 8; ++i)
    for (int j = -8; j <= 8; ++j) {
      x.row(3) << h + i * u, h + 0.25, h + j * u;
      Eigen::Matrix<long double, 3, 3> m;  // 64-bit mantissa: differences here are exact, the products nearly so
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) m(r, c) = static_cast<long double>(x(r + 1, c)) - x(0, c);
      // rows 0 and 1 lie in x = z, so the determinant is exactly (m22 - m20) (m00 m11 - m01 m10)
      const long double plane = m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
      const long double exact = (static_cast<long double>(x(3, 2)) - x(3, 0)) * plane;
      CHECK(find_inverted(x, tet).empty() == (exact >= 0));
      const Matrix3 plain = (x.bottomRows<3>().rowwise() - x.row(0));
      const double product = plain.row(0).cross(plain.row(1)).dot(plain.row(2));
      disagreements += (product < 0) != (exact < 0);
    }
  CHECK(disagreements > 0);  // so the exact predicate was needed
}

TEST_CASE("the airway of the larynx is filled with air, for linear and quadratic meshes") {
  for (const TetMesh& mesh : {larynx_mesh(Larynx::thesis_coarse()), quadratic_larynx_mesh(Larynx::thesis_coarse()),
                              larynx_mesh(Larynx::coarse()), quadratic_larynx_mesh(Larynx::coarse())}) {
    const Gap gap{mesh.points, flat_triangles(mesh.surface("airway_left")),
                  flat_triangles(mesh.surface("airway_right"))};
    const Airway airway = matched_airway(gap.points, gap.first, gap.second, {1, 0, 0});
    const Vector volumes = signed_volumes(mesh.points, airway.tets);
    CHECK(volumes.minCoeff() > 0);
    CHECK(find_inverted(mesh.points, airway.tets).empty());
    CHECK(volumes.sum() == approx(gap_volume(gap)).epsilon(1e-12));  // round-off of some 1000 terms
  }
}

TEST_CASE("a node without partner is named with its place") {
  Gap gap = facing_grids(2, wavy);
  gap.points(4, 1) += 1e-3;
  const std::string text = message_of(gap);
  CHECK(text.find("node 4 of first") != std::string::npos);
  CHECK(text.find(number_text(gap.points(4, 1))) != std::string::npos);
  gap.points(4, 1) -= 1e-3 - 1e-8;  // within 1e-6 of the extent
  CHECK(message_of(gap).empty());
}

TEST_CASE("surfaces that face only in part, differ in their diagonals or point inward are refused") {
  const Gap gap = facing_grids(2, wavy);
  Gap part = gap;
  part.second.conservativeResize(5, 3);
  CHECK(message_of(part) != "");
  Gap inward = gap;
  inward.first.col(0).swap(inward.first.col(1));
  CHECK(message_of(inward).find("opposite sense") != std::string::npos);
  inward.second.col(0).swap(inward.second.col(1));
  CHECK(message_of(inward).find("point into the tissue") != std::string::npos);
  Gap more = gap;
  more.second.conservativeResize(9, 3);
  more.second.row(8) = more.second.row(0);
  CHECK(message_of(more).find("as many as in first") != std::string::npos);
  CHECK(message_of(gap, {0, 0, 0}).find("direction") != std::string::npos);
}

TEST_CASE("positions that are not finite are refused") {
  Gap gap = facing_grids(1, wavy);
  const Airway airway = matched_airway(gap.points, gap.first, gap.second, {1, 0, 0});
  gap.points(0, 0) = std::nan("");
  CHECK_THROWS_AS(find_inverted(gap.points, airway.tets), InvalidInput);
  CHECK(message_of(gap).find("finite") != std::string::npos);
}

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>

#include "../approx.hpp"
#include "plica/contact/mortar.hpp"
#include "plica/core/error.hpp"
#include "plica/mesh/face.hpp"

using namespace plica;

namespace {

using Shape = std::function<double(double, double)>;

/// Two sheets over squares at heights z(x, y) that face each other, the upper finer one first, of three- or
/// six-node faces; each of n^2 squares cut in two.
struct Sheets {
  Points points{0, 3};
  Faces upper, lower;

  Sheets(int nodes_of_face, int n_upper, int n_lower, double low, double high, const Shape& z_upper,
         const Shape& z_lower) {
    upper = sheet(nodes_of_face, n_upper, 0, 1, z_upper, true);
    lower = sheet(nodes_of_face, n_lower, low, high, z_lower, false);
  }

  Detector detector() const {
    const Triangles first = flat_triangles(upper), second = flat_triangles(lower);
    // Air between all, so that every node can be a candidate: tetrahedra that are inside out.
    Tets tets(first.rows() + second.rows(), 4);
    for (std::ptrdiff_t t = 0; t < first.rows(); ++t) tets.row(t) << first.row(t), second(0, 0);
    for (std::ptrdiff_t t = 0; t < second.rows(); ++t) tets.row(first.rows() + t) << second.row(t), first(0, 0);
    Detector detector({first, second, tets}, points);
    detector.update(points);
    return detector;
  }

 private:
  Faces sheet(int nodes_of_face, int n, double low, double high, const Shape& z, bool faces_down) {
    const int m = nodes_of_face == 6 ? 2 * n : n, split = m / n;
    const auto start = static_cast<std::int32_t>(points.rows());
    points.conservativeResize(start + (m + 1) * (m + 1), 3);
    for (int j = 0; j <= m; ++j)
      for (int i = 0; i <= m; ++i) {
        const double x = low + (high - low) * i / m, y = low + (high - low) * j / m;
        points.row(start + j * (m + 1) + i) << x, y, z(x, y);
      }
    const auto node = [&](int i, int j) { return start + j * (m + 1) + i; };
    Faces faces(2 * n * n, nodes_of_face);
    for (int f = 0; f < 2 * n * n; ++f) {
      const int i = split * (f / 2 % n), j = split * (f / 2 / n);
      std::array<std::array<int, 2>, 3> corner{{{i, j}, {i + split, j}, {i + split, j + split}}};
      if (f % 2) corner = {{{i, j}, {i + split, j + split}, {i, j + split}}};
      if (faces_down) std::swap(corner[1], corner[2]);
      for (int k = 0; k < 3; ++k) {
        const auto &a = corner[static_cast<std::size_t>(k)], &b = corner[static_cast<std::size_t>((k + 1) % 3)];
        faces(f, k) = node(a[0], a[1]);
        if (nodes_of_face == 6) faces(f, 3 + k) = node((a[0] + b[0]) / 2, (a[1] + b[1]) / 2);
      }
    }
    return faces;
  }
};

constexpr double far = 10.0;  // m, a reach that leaves nothing out

/// The constraints of all corners of the slave side at the sheets' positions.
std::vector<Constraint> constraints(const Sheets& sheets, Detector& detector) {
  const auto mortar = mortar_averages(detector, sheets.upper, sheets.lower);
  std::vector<Constraint> found;
  const Faces of_corners = sheets.upper.leftCols(3);
  std::vector<std::int32_t> corners(of_corners.data(), of_corners.data() + of_corners.size());
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  for (const std::int32_t corner : corners)
    if (const Constraint mean = mortar->at(corner, sheets.points, far); mean.key >= 0) found.push_back(mean);
  return found;
}

double flat(double, double) { return 0.0; }
double bowl(double x, double y) { return 0.2 * (x * x + 0.5 * y * y - 0.3 * x * y); }

/// Integral over curved faces of shape functions times area, by a rule finer than any in use: (n).
Vector shares(const Faces& faces, const Points& x) {
  Vector shares = Vector::Zero(x.rows());
  constexpr int n = 60;
  for (std::ptrdiff_t f = 0; f < faces.rows(); ++f)
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {  // Duffy's square, by midpoints
        const double r = (i + 0.5) / n, s = (j + 0.5) / n * (1 - r);
        const FaceShapes shapes = face_shapes(faces.cols(), r, s);
        Vector3 along_r = Vector3::Zero(), along_s = Vector3::Zero();
        for (int k = 0; k < faces.cols(); ++k) {
          along_r += shapes.along_r[k] * x.row(faces(f, k)).transpose();
          along_s += shapes.along_s[k] * x.row(faces(f, k)).transpose();
        }
        const double weight = along_r.cross(along_s).norm() * (1 - r) / (n * n);
        for (int k = 0; k < faces.cols(); ++k) shares[faces(f, k)] += weight * shapes.value[k];
      }
  return shares;
}

}  // namespace

TEST_CASE("both sides of a mean are pushed alike, and turn nothing where the surfaces touch") {
  for (const int nodes : {3, 6}) {
    const Sheets sheets(nodes, 3, 2, 0, 1, bowl, bowl);
    Detector detector = sheets.detector();
    for (const Constraint& mean : constraints(sheets, detector)) {
      Vector3 moment = Vector3::Zero();
      double sum = 0, of_slave = 0, size = 0;
      for (const auto& [node, weight] : mean.weights) {
        sum += weight;
        if (detector.first().contains(node)) of_slave += weight;
        moment += weight * Vector3(sheets.points.row(node)).cross(mean.normal);
        size += std::abs(weight);
      }
      CHECK(std::abs(sum) < 1e-14 * size);
      CHECK(of_slave == approx(1).epsilon(1e-14));
      // Bilinear flat triangles of two meshes are apart by their sagitta; six-node faces contain the bowl.
      CHECK(moment.norm() < (nodes == 6 ? 1e-12 : 0.02));
      CHECK(std::abs(mean.gap(sheets.points)) < (nodes == 6 ? 1e-12 : 0.02));
    }
  }
}

TEST_CASE("means of a constant pressure are the consistent load of both surfaces, whether they match or not") {
  for (const int nodes : {3, 6})
    for (const int n_lower : {3, 2}) {
      CAPTURE(nodes);
      CAPTURE(n_lower);
      const Sheets sheets(nodes, 3, n_lower, 0, 1, flat, flat);
      Detector detector = sheets.detector();
      Vector load = Vector::Zero(sheets.points.rows());
      for (const Constraint& mean : constraints(sheets, detector))
        for (const auto& [node, weight] : mean.weights) load[node] += mean.area * weight;
      const Vector exact = shares(sheets.upper, sheets.points) - shares(sheets.lower, sheets.points);
      CHECK((load - exact).cwiseAbs().maxCoeff() < 1e-3 * exact.cwiseAbs().maxCoeff());  // of the rule of shares()
      CHECK(load.cwiseAbs().sum() == approx(2).epsilon(1e-12));
      if (nodes == 6) {
        const std::int32_t middle = 3 * 7 + 2;  // a mid-side inside the upper sheet
        CHECK(load[middle] == approx(2.0 / 3 / 18).epsilon(1e-12));
        CHECK(std::abs(load[2 * 7 + 2]) < 1e-15);  // a corner inside
      }
    }
}

TEST_CASE("on curved faces the slave's side is the consistent load, and the sum the curved area") {
  const Sheets sheets(6, 4, 3, 0, 1, bowl, bowl);
  Detector detector = sheets.detector();
  Vector load = Vector::Zero(sheets.points.rows());
  for (const Constraint& mean : constraints(sheets, detector))
    for (const auto& [node, weight] : mean.weights) load[node] += mean.area * weight;
  const Vector upper = shares(sheets.upper, sheets.points), lower = shares(sheets.lower, sheets.points);
  // The rim is seen along normals that are not those of the surface: some points beyond it are lost.
  CHECK(load.cwiseMax(0).sum() == approx(upper.sum()).epsilon(2e-3));
  CHECK((load - upper + lower).cwiseAbs().maxCoeff() < 0.02 * upper.maxCoeff());
}

TEST_CASE("a gap that is linear over a face is met exactly: its mean, weighted by the hat") {
  // The lower sheet lies below by 0.1 + 0.02 x; at an inner corner the mean is that at the corner.
  const Sheets sheets(6, 4, 3, -0.2, 1.2, flat, [](double x, double) { return -0.1 - 0.02 * x; });
  Detector detector = sheets.detector();
  int inner = 0;
  for (const Constraint& mean : constraints(sheets, detector)) {
    const Vector3 at = sheets.points.row(mean.slave);
    if (at.head<2>().minCoeff() < 0.1 || at.head<2>().maxCoeff() > 0.9) continue;
    ++inner;
    const double slope = 0.02, to_normal = std::cos(std::atan(slope)), half = std::cos(0.5 * std::atan(slope));
    // The foot is the closest point, the distance the height times to_normal, the normal half way between both.
    CHECK(mean.gap(sheets.points) == approx((0.1 + slope * at[0]) * to_normal * half).epsilon(1e-10));
  }
  CHECK(inner == 9);
}

TEST_CASE("what has nothing opposite does not count, and what lies beyond the reach does not either") {
  // The lower sheet is under the part x, y < 0.5 alone.
  const Sheets sheets(
      6, 4, 1, -0.5, 0.5, [](double, double) { return -0.01; }, flat);
  Detector detector = sheets.detector();
  REQUIRE(detector.slave_is_first());
  const auto mortar = mortar_averages(detector, sheets.upper, sheets.lower);
  // The hats of four squares each way, each cut along (1, 1): h^2 inside.
  double area = 0;
  for (const Constraint& mean : constraints(sheets, detector)) {
    area += mean.area;
    const Vector3 at = sheets.points.row(mean.slave);
    if (at[0] > 0 && at[1] > 0) CHECK(mean.support == approx(16 * mean.area).epsilon(1e-12));
    CHECK(mean.gap(sheets.points) == approx(-0.01).epsilon(1e-12));
    CHECK(mortar->at(mean.key, sheets.points, 0.005).key == -1);
  }
  CHECK(area == approx(0.25).epsilon(1e-12));
  CHECK(mortar->at(8 * 9 + 8, sheets.points, far).key == -1);
}

TEST_CASE("a node inside that its mean hides is found by itself") {
  // One mid-side of the lower sheet is raised through the flat upper one, which is 0.01 above.
  Sheets sheets(
      6, 2, 2, 0, 1, [](double, double) { return 0.01; }, flat);
  const std::int32_t raised = 25 + 2 * 5 + 1;
  sheets.points(raised, 2) = 0.05;
  Detector detector = sheets.detector();
  const auto mortar = mortar_averages(detector, sheets.upper, sheets.lower);
  mortar->update(sheets.points);
  const auto hidden = mortar->violated(sheets.points, far, detector.master_side(), 1e-6);
  REQUIRE(!hidden.empty());
  for (const std::int32_t key : hidden) {
    const Constraint node = mortar->at(key, sheets.points, far);
    CHECK(node.key == key);
    CHECK(node.slave == key - 50);
    CHECK(node.gap(sheets.points) < -0.01);
  }
  CHECK(hidden.back() == 50 + raised);
  sheets.points(raised, 2) = 0.0101;
  detector.update(sheets.points);
  mortar->update(sheets.points);
  CHECK(mortar->violated(sheets.points, far, detector.master_side(), 1e-6).empty());
}

TEST_CASE("pressure is linear between corners, the force of a mean over its area, and the same on both sides") {
  const Sheets sheets(6, 3, 2, 0, 1, flat, flat);
  Detector detector = sheets.detector();
  const auto mortar = mortar_averages(detector, sheets.upper, sheets.lower);
  std::vector<std::int32_t> keys;
  std::vector<double> forces;
  Vector nodal = Vector::Zero(3 * sheets.points.rows());
  const auto pressure_at = [](const Vector3& x) { return 100 + 30 * x[0] - 50 * x[1]; };
  for (const Constraint& mean : constraints(sheets, detector)) {
    keys.push_back(mean.key);
    forces.push_back(mean.area * pressure_at(sheets.points.row(mean.slave)));
    mean.row(mean.normal, 0.0).add_force(forces.back(), nodal);
  }
  const Vector force = Eigen::Map<const Vector>(forces.data(), static_cast<std::ptrdiff_t>(forces.size()));
  mortar->update(sheets.points);
  const Vector pressure = mortar->pressure({nodal, keys, force}, sheets.points);
  for (std::ptrdiff_t i = 0; i < sheets.points.rows(); ++i) {
    // The lower sheet's corners feel a little of a pressure that is not constant, or nothing at all.
    if (nodal.segment<3>(3 * i).isZero(0) && pressure[i] == 0) continue;
    CHECK(pressure[i] == approx(pressure_at(sheets.points.row(i))).epsilon(1e-12));
  }
  CHECK((pressure.array() > 0).count() >= 49 + 16);
  double area = 0;
  for (const PressedNode& node : mortar->pressed(detector.first(), {nodal, keys, force}, sheets.points)) {
    area += node.area;
    CHECK(node.pressure == approx(pressure[node.node]).epsilon(1e-14));
    const double y = sheets.points(node.node, 1);  // to the mid-sides, half of a third away
    CHECK(node.stretch.first == approx(std::max(0.0, y - 1.0 / 6)).epsilon(1e-12));
    CHECK(node.stretch.second == approx(std::min(1.0, y + 1.0 / 6)).epsilon(1e-12));
  }
  CHECK(area == approx(1).epsilon(1e-12));
}

TEST_CASE("faces that are not the airway's are refused") {
  const Sheets sheets(6, 2, 2, 0, 1, flat, flat);
  Detector detector = sheets.detector();
  CHECK_THROWS_WITH_AS(
      mortar_averages(detector, sheets.lower, sheets.upper),
      "Mortar: first; must have the flat triangles of the airway's surface of that name, in their "
      "order.",
      InvalidInput);
}

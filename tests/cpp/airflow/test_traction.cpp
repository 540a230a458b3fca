#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <random>

#include "../approx.hpp"
#include "plica/airflow/traction.hpp"
#include "plica/mesh/block.hpp"

using namespace plica;

namespace {

FaceVectors rows(const Points& x, const Faces& faces, std::ptrdiff_t f) {
  FaceVectors at(faces.cols(), 3);
  for (int c = 0; c < faces.cols(); ++c) at.row(c) = x.row(faces(f, c));
  return at;
}

/// A block with all its nodes moved at random, so that six-node faces are curved.
TetMesh crumpled(bool quadratic) {
  Block block;
  block.size = {1, 2, 1.5};
  block.divisions = {2, 3, 2};
  TetMesh mesh = block_mesh(block);
  if (quadratic) mesh = to_quadratic(mesh);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> by(-0.08, 0.08);
  for (auto& value : mesh.points.reshaped()) value += by(random);
  return mesh;
}

/// A curved six-node face, and N of VTK's quadratic triangle.
FaceVectors curved() {
  FaceVectors x(6, 3);
  x << 0, 0, 0, 1, 0.1, 0, 0.2, 1.1, 0.3, 0.5, -0.1, 0.2, 0.7, 0.6, 0.1, 0.1, 0.5, -0.2;
  return x;
}
double shape(int l, double r, double s) {
  const double t = 1 - r - s;
  const double n[6] = {t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t};
  return n[l];
}

}  // namespace

TEST_CASE("constant pressure on a closed surface has neither force nor moment") {
  for (const bool quadratic : {false, true}) {
    const TetMesh mesh = crumpled(quadratic);
    const Faces faces = boundary_of(mesh.cells).faces;
    Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
    double size = 0;
    for (std::ptrdiff_t f = 0; f < faces.rows(); ++f) {
      const FaceVectors x = rows(mesh.points, faces, f);
      const FaceVectors load = pressure_load(x, FaceValues::Constant(x.rows(), 800));
      for (int c = 0; c < x.rows(); ++c) {
        force += load.row(c).transpose();
        moment += x.row(c).cross(load.row(c)).transpose();
        size += load.row(c).norm();
      }
    }
    CHECK(size > 1000);                  // N: 800 Pa on some 13 m^2
    CHECK(force.norm() < 1e-13 * size);  // round-off of some 500 terms
    CHECK(moment.norm() < 3e-13 * size);
  }
}

TEST_CASE("a flat patch receives pressure times area, into the tissue") {
  for (const bool quadratic : {false, true}) {
    Block block;
    block.size = {2, 3, 1};
    block.divisions = {3, 2, 1};
    TetMesh mesh = block_mesh(block);
    if (quadratic) mesh = to_quadratic(mesh);
    const Faces& top = mesh.surface("z_max");
    Vector3 force = Vector3::Zero();
    for (std::ptrdiff_t f = 0; f < top.rows(); ++f) {
      const FaceVectors load = pressure_load(rows(mesh.points, top, f), FaceValues::Constant(top.cols(), 50));
      force += load.colwise().sum().transpose();
    }
    CHECK((force - Vector3(0, 0, -300)).norm() < 1e-11);  // 50 Pa on 6 m^2, to round-off
  }
}

TEST_CASE("linear pressure on a triangle gives Eq. (17)") {
  FaceVectors x(3, 3);
  x << 0, 0, 0, 2, 0, 0, 0, 3, 0;  // area 3, normal +z
  FaceValues p(3);
  p << 1, 5, 11;
  const FaceVectors load = pressure_load(x, p);
  CHECK(load.leftCols<2>().norm() == 0);
  CHECK(load(0, 2) == approx(-3.0 / 6 * (1 + 5 / 2.0 + 11 / 2.0)));
  CHECK(load(1, 2) == approx(-3.0 / 6 * (1 / 2.0 + 5 + 11 / 2.0)));
  CHECK(load(2, 2) == approx(-3.0 / 6 * (1 / 2.0 + 5 / 2.0 + 11)));
}

TEST_CASE("constant pressure on a flat six-node face loads the mid-sides with a third each and the corners not") {
  FaceVectors x(6, 3);
  x << 0, 0, 0, 2, 0, 0, 0, 3, 0, 1, 0, 0, 1, 1.5, 0, 0, 1.5, 0;
  const FaceVectors load = pressure_load(x, FaceValues::Constant(6, 7));
  for (int c = 0; c < 3; ++c) CHECK(std::abs(load(c, 2)) < 1e-14);  // round-off of 21 N
  for (int c = 3; c < 6; ++c) CHECK(load(c, 2) == approx(-7.0));
}

TEST_CASE("on a curved face the load is the integral of the isoparametric pressure") {
  const FaceVectors x = curved();
  FaceValues p(6);
  p << 3, -1, 4, 1, 5, -9;
  const FaceVectors load = pressure_load(x, p);
  // Midpoint rule on the reference triangle, refined; tangents by central differences, exact for quadratics.
  FaceVectors sum = FaceVectors::Zero(6, 3);
  const int n = 300;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < 2 * (n - i) - 1; ++j) {
      const double third = j % 2 ? 2.0 / 3 : 1.0 / 3;  // centroids of upright and inverted small triangles
      const double r = (i + third) / n, s = (j / 2 + third) / n;
      Eigen::RowVector3d along_r = Eigen::RowVector3d::Zero(), along_s = along_r;
      double pressure = 0;
      for (int l = 0; l < 6; ++l) {
        along_r += (shape(l, r + 0.5, s) - shape(l, r - 0.5, s)) * x.row(l);
        along_s += (shape(l, r, s + 0.5) - shape(l, r, s - 0.5)) * x.row(l);
        pressure += p[l] * shape(l, r, s);
      }
      for (int l = 0; l < 6; ++l) sum.row(l) -= pressure * shape(l, r, s) * along_r.cross(along_s) / (2.0 * n * n);
    }
  CHECK(load.norm() > 0.5);
  CHECK((load - sum).norm() < 1e-4 * load.norm());  // the midpoint rule: (1 / 300)^2 times second derivatives
}

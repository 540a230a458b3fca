#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "../approx.hpp"
#include "plica/airflow/traction.hpp"

using namespace plica;

namespace {

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

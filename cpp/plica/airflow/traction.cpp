#include "plica/airflow/traction.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "plica/core/require.hpp"
#include "plica/mesh/face.hpp"

namespace plica {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

/// What is constant on the six-node triangle. The area vector x_r x x_s is quadratic in (r, s), hence equal to
/// its interpolant by the six shape functions, and F_l = -sum_mk T_lmk p_k a_m with T_lmk = int N_l N_m N_k.
struct SixNodes {
  Matrix6 along_r, along_s;        // row m: dN_k/dr, dN_k/ds at node m
  std::array<Matrix6, 6> product;  // T_lmk

  SixNodes() {
    const std::array<std::array<double, 2>, 6> nodes{{{0, 0}, {1, 0}, {0, 1}, {0.5, 0}, {0.5, 0.5}, {0, 0.5}}};
    for (int m = 0; m < 6; ++m) {
      const FaceShapes shapes = face_shapes(6, nodes[m][0], nodes[m][1]);
      along_r.row(m) = shapes.along_r;
      along_s.row(m) = shapes.along_s;
    }
    // Gauss rule of four points in both directions of the collapsed square: exact to degree 6 on the triangle.
    const double root = 2.0 / 7.0 * std::sqrt(6.0 / 5.0), wide = std::sqrt(3.0 / 7.0 + root),
                 narrow = std::sqrt(3.0 / 7.0 - root), light = (18 - std::sqrt(30.0)) / 72,
                 heavy = (18 + std::sqrt(30.0)) / 72;
    const std::array<double, 4> at{(1 - wide) / 2, (1 - narrow) / 2, (1 + narrow) / 2, (1 + wide) / 2};
    const std::array<double, 4> weight{light, heavy, heavy, light};
    for (auto& slice : product) slice.setZero();
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const Vector6 n = face_shapes(6, at[i], at[j] * (1 - at[i])).value;
        for (int l = 0; l < 6; ++l) product[l] += weight[i] * weight[j] * (1 - at[i]) * n[l] * n * n.transpose();
      }
  }
};

}  // namespace

FaceVectors pressure_load(const FaceVectors& x, const FaceValues& pressure) {
  require_size("pressure_load", "x", x.rows(), 3, 6);
  require_size("pressure_load", "pressure", pressure.size(), x.rows());
  FaceVectors force(x.rows(), 3);
  if (x.rows() == 3) {
    const Eigen::RowVector3d u = x.row(1) - x.row(0), v = x.row(2) - x.row(0);
    const Eigen::RowVector3d area = 0.5 * u.cross(v);
    const double sum = pressure[0] + pressure[1] + pressure[2];
    for (int l = 0; l < 3; ++l) force.row(l) = -(sum + pressure[l]) / 12 * area;
    return force;
  }
  static const SixNodes six;
  const Eigen::Matrix<double, 6, 3, Eigen::RowMajor> nodes = x, u = six.along_r * nodes, v = six.along_s * nodes;
  const Vector6 p = pressure;
  Eigen::Matrix<double, 6, 3, Eigen::RowMajor> area;
  for (int m = 0; m < 6; ++m) area.row(m) = u.row(m).cross(v.row(m));
  for (int l = 0; l < 6; ++l) force.row(l) = -(six.product[l] * p).transpose() * area;
  return force;
}

}  // namespace plica

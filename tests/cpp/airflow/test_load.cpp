#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "../approx.hpp"
#include "plica/airflow/airflow.hpp"
#include "plica/mesh/face.hpp"
#include "plica/mesh/larynx.hpp"

using namespace plica;

TEST_CASE("the work of the load is pressure times the volume swept in each section's part") {
  // Curved faces: a larynx with quadratic sides, its mid-sides moved off the chords.
  TetMesh mesh = to_quadratic(larynx_mesh(Larynx::thesis_coarse()));
  const Faces& wall = mesh.surface("airway");
  for (const auto& face : wall.rowwise())
    for (int c = 3; c < 6; ++c) mesh.points(face[c], 0) *= 1.02;
  Airflow::Options options;
  options.area = CutSections{15};
  const Airflow airflow(mesh, wall, options);
  const Vector& height = airflow.sections().height;
  const Vector pressure = Vector::LinSpaced(15, 750, -90);
  Vector force = Vector::Zero(mesh.points.size());
  airflow.add_load(mesh.points, {800, pressure}, force);
  const auto moved = [&](double by) {
    Points x = mesh.points;
    for (auto p : x.rowwise())
      p += by * Eigen::RowVector3d(std::sin(300 * p[1] + 200 * p[2]), std::cos(250 * p[0]) * p[1] * 100,
                                   std::sin(400 * p[1]));
    return x;
  };
  /// Integral of p(z) over the air, by the divergence theorem: of the flux of (0, 0, P(z)), P' = p, through the
  /// wall and the ends, which do not move here. Fine facets, one point each.
  const auto primitive = [&](double z) {
    double sum = airflow.options().subglottal_pressure * (std::min(z, height[0]) - height[0]);
    for (int i = 0; i + 1 < 15; ++i) {
      const double t = std::clamp((z - height[i]) / (height[i + 1] - height[i]), 0.0, 1.0);
      sum += (height[i + 1] - height[i]) * (t * pressure[i] + t * t / 2 * (pressure[i + 1] - pressure[i]));
    }
    return sum;
  };
  const auto energy = [&](const Points& x) {
    constexpr int n = 24;
    double sum = 0;
    for (const auto& face : wall.rowwise())
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < 2 * (n - i) - 1; ++j) {
          const double third = j % 2 ? 2.0 / 3 : 1.0 / 3, r = (i + third) / n, s = (j / 2 + third) / n;
          const FaceShapes shapes = face_shapes(6, r, s);
          Vector3 at = Vector3::Zero(), u = at, v = at;
          for (int k = 0; k < 6; ++k) {
            at += shapes.value[k] * x.row(face[k]).transpose();
            u += shapes.along_r[k] * x.row(face[k]).transpose();
            v += shapes.along_s[k] * x.row(face[k]).transpose();
          }
          sum -= primitive(at[2]) * u.cross(v)[2] / (2.0 * n * n);  // the normal points into the air
        }
    return sum;
  };
  const double by = 1e-6;  // m
  const Vector step = as_vector(Points((moved(by) - moved(-by)) / (2 * by)));
  // The rims carry ends that move: only a motion that leaves them in their planes is a change of the wall alone.
  Vector held = step;
  const double low = mesh.points.col(2).minCoeff(), high = mesh.points.col(2).maxCoeff();
  Points there = mesh.points, back = mesh.points;
  for (std::ptrdiff_t n = 0; n < mesh.node_count(); ++n) {
    const double z = mesh.points(n, 2), from_ends = std::min(z - low, high - z);
    held.segment<3>(3 * n) *= from_ends < 2e-3 ? 0 : 1;
    there.row(n) += by * held.segment<3>(3 * n).transpose();
    back.row(n) -= by * held.segment<3>(3 * n).transpose();
  }
  const double work = force.dot(held), change = (energy(there) - energy(back)) / (2 * by);
  CHECK(std::abs(work) > 1e-3);
  CHECK(work == approx(change).epsilon(2e-3));  // the sum over facets: (1 / 24)^2 and hats' kinks
}

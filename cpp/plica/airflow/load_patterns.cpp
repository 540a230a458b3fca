#include "plica/airflow/load_patterns.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "plica/airflow/facets.hpp"
#include "plica/core/require.hpp"

namespace plica {
namespace {

struct QuadraturePoint {
  double r, s, weight;
};

/// Six points on the reference triangle, exact to degree 4 (Strang and Fix 1973; Dunavant 1985).
std::array<QuadraturePoint, 6> degree_four() {
  constexpr double a = 0.445948490915965, b = 0.091576213509771, wa = 0.223381589678011 / 2,
                   wb = 0.109951743655322 / 2;
  return {
      {{a, a, wa}, {1 - 2 * a, a, wa}, {a, 1 - 2 * a, wa}, {b, b, wb}, {1 - 2 * b, b, wb}, {b, 1 - 2 * b, wb}}};
}

/// i of the interval [i, i + 1] that holds z, or is nearest to it; 0 where there is one section only.
std::ptrdiff_t interval_of(const Vector& height, double z) {
  const auto i = std::upper_bound(height.begin(), height.end(), z) - height.begin() - 1;
  return std::clamp<std::ptrdiff_t>(i, 0, std::max<std::ptrdiff_t>(height.size() - 2, 0));
}

}  // namespace

AirwayExpansion LoadPatterns::expansion(const Vector& velocity) const {
  require_size("LoadPatterns", "velocity", velocity.size(), sections.rows());
  return {below.dot(velocity), sections.transpose() * velocity, above.dot(velocity)};
}

LoadPatterns load_patterns(const Points& x, const Faces& faces, const Vector& height, double same) {
  require_size("load_patterns", "a face", faces.cols(), 3, 6);
  require_indices("load_patterns", "node of a face", faces, x.rows());
  require_at_least("load_patterns", "height", height.size(), 1);
  const std::ptrdiff_t count = height.size(), width = faces.cols();
  const Facets facets(width);
  struct Sample {
    FaceShapes shapes;
    double weight;
  };
  std::vector<Sample> samples;
  const double part = 1.0 / static_cast<double>(facets.triangles.size());
  for (const auto& facet : facets.triangles) {
    const Eigen::Vector2d o = facets.corners[facet[0]], u = facets.corners[facet[1]] - o,
                          v = facets.corners[facet[2]] - o;
    for (const auto& q : degree_four()) {
      const Eigen::Vector2d at = o + q.r * u + q.s * v;
      samples.push_back({face_shapes(width, at[0], at[1]), part * q.weight});
    }
  }
  LoadPatterns patterns{{x.size(), count}, Vector::Zero(x.size()), Vector::Zero(x.size())};
  std::vector<Eigen::Triplet<double>> entries;
  Points nodes(width, 3);
  for (std::ptrdiff_t f = 0; f < faces.rows(); ++f) {
    for (std::ptrdiff_t c = 0; c < width; ++c) nodes.row(c) = x.row(faces(f, c));
    Vector z(static_cast<std::ptrdiff_t>(samples.size()));
    for (std::ptrdiff_t q = 0; q < z.size(); ++q)
      z[q] = samples[static_cast<std::size_t>(q)].shapes.value.dot(nodes.col(2));
    const std::ptrdiff_t from = interval_of(height, z.minCoeff());
    const std::ptrdiff_t to = std::min(interval_of(height, z.maxCoeff()) + 1, count - 1);
    Eigen::MatrixXd local = Eigen::MatrixXd::Zero(3 * width, to - from + 1);  // sections from .. to
    Vector below = Vector::Zero(3 * width), above = Vector::Zero(3 * width);
    for (std::ptrdiff_t q = 0; q < z.size(); ++q) {
      const auto& [shapes, weight] = samples[static_cast<std::size_t>(q)];
      const Vector3 u = nodes.transpose() * shapes.along_r, v = nodes.transpose() * shapes.along_s;
      const Vector3 area = weight * u.cross(v);
      Vector load(3 * width);
      for (std::ptrdiff_t l = 0; l < width; ++l) load.segment<3>(3 * l) = -shapes.value[l] * area;
      const bool under = z[q] < height[0] - same;
      if (under || z[q] > height[count - 1] + same) {
        (under ? below : above) += load;
        continue;
      }
      const std::ptrdiff_t i = interval_of(height, z[q]), next = std::min(i + 1, count - 1);
      const double t = next > i ? std::clamp((z[q] - height[i]) / (height[next] - height[i]), 0.0, 1.0) : 0;
      if (t < 1) local.col(i - from) += (1 - t) * load;
      if (t > 0) local.col(next - from) += t * load;
    }
    for (std::ptrdiff_t l = 0; l < width; ++l)
      for (int c = 0; c < 3; ++c) {
        const std::ptrdiff_t row = 3 * faces(f, l) + c;
        patterns.below[row] += below[3 * l + c];
        patterns.above[row] += above[3 * l + c];
        for (std::ptrdiff_t i = from; i <= to; ++i)
          if (local(3 * l + c, i - from) != 0)
            entries.emplace_back(static_cast<int>(row), static_cast<int>(i), local(3 * l + c, i - from));
      }
  }
  patterns.sections.setFromTriplets(entries.begin(), entries.end());
  return patterns;
}

}  // namespace plica

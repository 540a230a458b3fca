#include "plica/contact/triangle_overlap.hpp"

#include <Eigen/Geometry>

namespace plica {

namespace {

using Place = Eigen::Vector2d;

double cross_in_plane(const Place& a, const Place& b) { return a[0] * b[1] - a[1] * b[0]; }

/// Barycentric coordinate k of a place: >= 0 for all three inside the triangle.
double inside(const Place& p, int k) { return k == 0 ? 1 - p[0] - p[1] : p[k - 1]; }

/// The polygon without what lies beyond side k.
std::vector<Place> cut(const std::vector<Place>& polygon, int k) {
  std::vector<Place> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Place &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double of_a = inside(a, k), of_b = inside(b, k);
    if (of_a >= 0) kept.push_back(a);
    if ((of_a > 0 && of_b < 0) || (of_a < 0 && of_b > 0)) kept.push_back(a + of_a / (of_a - of_b) * (b - a));
  }
  return kept;
}

/// Six points on a triangle, exact to degree 4 (Cowper 1973): barycentric coordinates (1 - 2 a, a, a), weight.
constexpr std::array<std::array<double, 2>, 2> rule{
    {{0.445948490915965, 0.223381589678011}, {0.091576213509771, 0.109951743655322}}};

}  // namespace

std::array<Eigen::Vector2d, 3> seen_from(const std::array<Vector3, 3>& triangle,
                                         const std::array<Vector3, 3>& other) {
  const Vector3 u = triangle[1] - triangle[0], v = triangle[2] - triangle[0];
  const Vector3 n = u.cross(v);
  const double scale = 1 / n.squaredNorm();
  std::array<Eigen::Vector2d, 3> seen;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 d = other[k] - triangle[0];
    seen[k] = {scale * n.dot(d.cross(v)), scale * n.dot(u.cross(d))};
  }
  return seen;
}

std::vector<TrianglePoint> overlap_points(const std::array<Eigen::Vector2d, 3>& other) {
  constexpr double nothing = 1e-12;  // twice the area of the triangle is 1: round-off between matching ones
  std::vector<TrianglePoint> points;
  if (!(cross_in_plane(other[1] - other[0], other[2] - other[0]) < 0)) return points;
  std::vector<Place> polygon{other[0], other[2], other[1]};
  for (int k = 0; k < 3 && !polygon.empty(); ++k) polygon = cut(polygon, k);
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
    const std::array<Place, 3> corner{polygon[0], polygon[i], polygon[i + 1]};
    const double twice_area = cross_in_plane(corner[1] - corner[0], corner[2] - corner[0]);
    if (twice_area < nothing) continue;
    const Place sum = corner[0] + corner[1] + corner[2];
    for (const auto& [a, weight] : rule)
      for (const Place& c : corner) points.push_back({a * sum + (1 - 3 * a) * c, 0.5 * twice_area * weight});
  }
  return points;
}

}  // namespace plica

#include "plica/imaging/surface_values.hpp"

#include <Eigen/Geometry>

#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"

namespace plica::imaging {

Table interpolated(const Table& weights, const Faces& rows, const Table& values) {
  const char* const where = "interpolated";
  require_size(where, "weights", weights.rows(), rows.rows());
  require_size(where, "a row of weights", weights.cols(), rows.cols());
  require_indices(where, "rows", rows, values.rows());
  Table found = Table::Zero(rows.rows(), values.cols());
  for_slices(rows.rows(), [&](std::ptrdiff_t at, std::ptrdiff_t count) {
    for (std::ptrdiff_t p = at; p < at + count; ++p)
      for (std::ptrdiff_t k = 0; k < rows.cols(); ++k)
        for (std::ptrdiff_t c = 0; c < values.cols(); ++c) found(p, c) += weights(p, k) * values(rows(p, k), c);
  });
  return found;
}

Points corner_normals(const Points& corners, const Triangles& triangles) {
  require_indices("corner_normals", "triangles", triangles, corners.rows());
  Points normals = Points::Zero(corners.rows(), 3);
  for (std::ptrdiff_t t = 0; t < triangles.rows(); ++t) {
    const auto corner = [&](int k) { return Vector3(corners.row(triangles(t, k)).transpose()); };
    const Vector3 a = corner(0), own = (corner(1) - a).cross(corner(2) - a);
    for (int k = 0; k < 3; ++k) normals.row(triangles(t, k)) += own.transpose();
  }
  return normals;
}

Eigen::Array<bool, Eigen::Dynamic, 1> within_hull(const Points& sides, const Pairs& places) {
  Eigen::Array<bool, Eigen::Dynamic, 1> inside(places.rows());
  for_slices(places.rows(), [&](std::ptrdiff_t at, std::ptrdiff_t count) {
    for (std::ptrdiff_t p = at; p < at + count; ++p) {
      const double x = places(p, 0), y = places(p, 1);
      bool held = true;
      for (std::ptrdiff_t s = 0; held && s < sides.rows(); ++s)
        held = sides(s, 0) * x + sides(s, 1) * y + sides(s, 2) <= 0;
      inside[p] = held;
    }
  });
  return inside;
}

}  // namespace plica::imaging

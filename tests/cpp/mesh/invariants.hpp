#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "plica/mesh/larynx.hpp"
#include "plica/mesh/tet_mesh.hpp"

namespace plica::test {

/// How often each face (its three corners, ascending) is a face of a cell.
inline std::map<std::array<std::int32_t, 3>, int> face_uses(const Cells& cells) {
  std::map<std::array<std::int32_t, 3>, int> uses;
  for (Eigen::Index e = 0; e < cells.rows(); ++e)
    for (int omitted = 0; omitted < 4; ++omitted) {
      std::array<std::int32_t, 3> face{};
      for (int k = 0, at = 0; k < 4; ++k)
        if (k != omitted) face[at++] = cells(e, k);
      std::sort(face.begin(), face.end());
      ++uses[face];
    }
  return uses;
}

/// Area vector of a flat triangle, m^2, along its outward normal.
inline Vector3 area_vector(const Points& x, std::int32_t a, std::int32_t b, std::int32_t c) {
  const Vector3 first = x.row(b) - x.row(a), second = x.row(c) - x.row(a);
  return 0.5 * first.cross(second);
}

inline Vector3 area_vector(const Points& x, const Faces& faces) {
  Vector3 sum = Vector3::Zero();
  for (Eigen::Index f = 0; f < faces.rows(); ++f) sum += area_vector(x, faces(f, 0), faces(f, 1), faces(f, 2));
  return sum;
}

/// Volume inside a closed outward surface by the divergence theorem, V = sum x . A / 3.
inline double enclosed_volume(const Points& x, const Faces& faces) {
  double sum = 0;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    sum += x.row(faces(f, 0)).dot(area_vector(x, faces(f, 0), faces(f, 1), faces(f, 2))) / 3;
  return sum;
}

/// Mean ratio 12 (3 V)^(2/3) / sum of squared edge lengths: 1 where regular, 0 where flat.
inline double worst_mean_ratio(const Points& x, const Cells& cells) {
  const Vector volume = signed_volumes(x, cells);
  double worst = 1;
  for (Eigen::Index e = 0; e < cells.rows(); ++e) {
    double squares = 0;
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < a; ++b) squares += (x.row(cells(e, a)) - x.row(cells(e, b))).squaredNorm();
    worst = std::min(worst, 12 * std::cbrt(9 * volume[e] * volume[e]) / squares);
  }
  return worst;
}

inline const double pi = std::acos(-1.0);

/// Volume of the cylinder less the elliptic airway, exact: the minor axis is linear between sections.
inline double exact_volume(const Larynx::Shape& shape) {
  double volume = 0;
  for (std::size_t k = 0; k + 1 < shape.sections.size(); ++k) {
    const auto &a = shape.sections[k], &b = shape.sections[k + 1];
    volume += (b.z - a.z) * pi * (shape.radius * shape.radius - shape.major * (a.minor + b.minor) / 2);
  }
  return volume;
}

/// The node at the mirror image of each one, found by its exact coordinates; -1 where there is none.
inline std::vector<std::int32_t> mirror_nodes(const Points& x, double sign_x, double sign_y) {
  std::map<std::array<double, 3>, std::int32_t> place;
  for (std::int32_t n = 0; n < x.rows(); ++n) place[{x(n, 0), x(n, 1), x(n, 2)}] = n;
  std::vector<std::int32_t> image(x.rows(), -1);
  for (std::int32_t n = 0; n < x.rows(); ++n) {
    const auto found = place.find({sign_x * x(n, 0), sign_y * x(n, 1), x(n, 2)});
    if (found != place.end()) image[n] = found->second;
  }
  return image;
}

template <class Rows>
std::set<std::vector<std::int32_t>> as_set(const Rows& rows, const std::vector<std::int32_t>& image = {}) {
  std::set<std::vector<std::int32_t>> all;
  for (Eigen::Index e = 0; e < rows.rows(); ++e) {
    std::vector<std::int32_t> nodes;
    for (const std::int32_t node : rows.row(e)) nodes.push_back(image.empty() ? node : image[node]);
    std::sort(nodes.begin(), nodes.end());
    all.insert(nodes);
  }
  return all;
}

}  // namespace plica::test

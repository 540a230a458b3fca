#include "plica/contact/facing.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "plica/contact/triangle_overlap.hpp"

namespace plica {

namespace {

/// The point of a curved face that is closest to p, by Gauss and Newton's iteration from (r, s).
struct CurvedFoot {
  FaceShapes shapes;
  bool inside;  // else on a rim that lies beyond the face's by a tenth: the face is continued that far
};
CurvedFoot closest_on(const FaceNodes& nodes, const Vector3& p, Eigen::Vector2d at) {
  constexpr int most = 10;  // a step leaves the gap times the curvature
  constexpr double beyond = 0.1, small = 1e-12;
  CurvedFoot foot{face_shapes(nodes.cols(), at[0], at[1]), true};
  for (int k = 0; k < most; ++k) {
    Eigen::Matrix<double, 3, 2> tangents;
    tangents << nodes * foot.shapes.along_r, nodes * foot.shapes.along_s;
    const Eigen::Matrix2d metric = tangents.transpose() * tangents;
    Eigen::Vector2d to =
        at + metric.inverse() * Eigen::Vector2d(tangents.transpose() * (p - nodes * foot.shapes.value));
    if (!to.allFinite()) break;  // a face without area
    foot.inside = to.minCoeff() >= -beyond && to.sum() <= 1 + beyond;
    to = to.cwiseMax(-beyond);
    if (const double sum = to.sum(); sum > 1 + beyond)
      to = (to.array() + beyond) * ((1 + 3 * beyond) / (sum + 2 * beyond)) - beyond;
    const double step = (to - at).cwiseAbs().maxCoeff();
    at = to;
    foot.shapes = face_shapes(nodes.cols(), at[0], at[1]);
    if (step < small) break;
  }
  return foot;
}

Vector3 area_vector(const FaceNodes& nodes, const FaceShapes& shapes) {
  return (nodes * shapes.along_r).cross(nodes * shapes.along_s);
}

}  // namespace

FacingPoints::FacingPoints(const FacedSide& slave, const FacedSide& master)
    : slave_(slave),
      master_(master),
      points_(static_cast<std::size_t>(slave.faces.rows())),
      seen_(static_cast<std::size_t>(master.flat.triangles().rows()), 0) {}

void FacingPoints::update() {
  for (const std::int32_t face : known_) points_[static_cast<std::size_t>(face)].reset();
  known_.clear();
}

const std::vector<FacingPoint>& FacingPoints::of(std::int32_t face, const Points& x) {
  auto& points = points_[static_cast<std::size_t>(face)];
  if (!points) {
    points.emplace();
    for (int k = 0; k < slave_.split(); ++k) find(slave_.split() * face + k, x, *points);
    known_.push_back(face);
  }
  return *points;
}

void FacingPoints::find(std::int32_t triangle, const Points& x, std::vector<FacingPoint>& points) {
  const std::int32_t face = slave_.face_of(triangle);
  const std::array<Vector3, 3> corners = slave_.corners(triangle, x);
  const FaceNodes nodes = slave_.nodes(face, x);
  const ParameterTriangle& in_face = slave_.in_face(triangle);
  const Eigen::Vector2d u = in_face[1] - in_face[0], v = in_face[2] - in_face[0];
  const double share = u[0] * v[1] - u[1] * v[0];
  for (const std::int32_t other : facing_triangles(corners, x))
    for (const auto& [place, weight] : overlap_points(seen_from(corners, master_.corners(other, x)))) {
      const Eigen::Vector2d at = in_face[0] + place[0] * u + place[1] * v;
      const FaceShapes slave = face_shapes(nodes.cols(), at[0], at[1]);
      const Vector3 p = nodes * slave.value, area = area_vector(nodes, slave);
      const auto [master_face, master] = foot(other, p, x);
      const FaceNodes of_master = master_.nodes(master_face, x);
      const Vector3 n_slave = area.normalized(), n_master = area_vector(of_master, master).normalized();
      const double square = -n_slave.dot(n_master);
      if (!(square > 0)) continue;
      const Vector3 d = p - of_master * master.value;
      points.push_back({Vector3(1 - at[0] - at[1], at[0], at[1]), weight * share * square * area.norm(),
                        n_master.dot(d) < 0 ? d.norm() : 0.0, n_master - n_slave, slave.value, master.value,
                        master_face});
    }
}

std::vector<std::int32_t> FacingPoints::facing_triangles(const std::array<Vector3, 3>& corners, const Points& x) {
  ++search_;
  std::vector<std::int32_t> queue, found;
  const auto enqueue_around = [&](std::int32_t centre) {
    for (const std::int32_t node : master_.flat.triangles().row(centre))
      for (const std::int32_t next : master_.flat.fan(node))
        if (std::int64_t& seen = seen_[static_cast<std::size_t>(next)]; seen != search_) {
          seen = search_;
          queue.push_back(next);
        }
  };
  const Vector3 centre = (corners[0] + corners[1] + corners[2]) / 3.0;
  enqueue_around(master_.flat.closest(x, centre).triangle);
  for (std::size_t next = 0; next < queue.size(); ++next) {
    const std::int32_t other = queue[next];
    if (overlap_points(seen_from(corners, master_.corners(other, x))).empty()) continue;
    found.push_back(other);
    enqueue_around(other);
  }
  return found;
}

FacingPoints::FaceFoot FacingPoints::foot(std::int32_t triangle, const Vector3& p, const Points& x) const {
  const auto on_face_of = [&](std::int32_t of, const Vector3& w) {
    const ParameterTriangle& in_face = master_.in_face(of);
    return closest_on(master_.nodes(master_.face_of(of), x), p,
                      w[0] * in_face[0] + w[1] * in_face[1] + w[2] * in_face[2]);
  };
  const auto [a, b, c] = master_.corners(triangle, x);
  const CurvedFoot beside = on_face_of(triangle, closest_weights(p, a, b, c));
  if (beside.inside) return {master_.face_of(triangle), beside.shapes};
  const Foot nearest = master_.flat.closest(x, p);
  return {master_.face_of(nearest.triangle), on_face_of(nearest.triangle, nearest.weights).shapes};
}

}  // namespace plica

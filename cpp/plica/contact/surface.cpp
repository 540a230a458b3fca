#include "plica/contact/surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"

namespace plica {

Vector3 closest_weights(const Vector3& p, const Vector3& a, const Vector3& b, const Vector3& c) {
  // The plane splits into seven regions (a face, three edges, three corners); each is recognised by the
  // signs of the projections of p - corner onto the edges.
  const Vector3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const Vector3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const double t = d1 / (d1 - d3);
    return {1 - t, t, 0};
  }
  const Vector3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const double t = d2 / (d2 - d6);
    return {1 - t, 0, t};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - t, t};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

ContactSurface::ContactSurface(Triangles triangles, std::ptrdiff_t node_count)
    : triangles_(std::move(triangles)), local_(static_cast<std::size_t>(node_count), -1) {
  if (triangles_.rows() == 0)
    throw InvalidInput("Contact: surface has no triangle; must have at least one. Name another surface.");
  require_indices("Contact", "node of a surface", triangles_, node_count);
  nodes_.assign(triangles_.data(), triangles_.data() + triangles_.size());
  std::sort(nodes_.begin(), nodes_.end());
  nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    local_[static_cast<std::size_t>(nodes_[i])] = static_cast<std::int32_t>(i);

  fan_start_.assign(nodes_.size() + 1, 0);
  for (std::ptrdiff_t k = 0; k < triangles_.size(); ++k) ++fan_start_[local_[triangles_.data()[k]] + 1];
  for (std::size_t i = 0; i < nodes_.size(); ++i) fan_start_[i + 1] += fan_start_[i];
  fan_.resize(static_cast<std::size_t>(triangles_.size()));
  std::vector<std::int32_t> next(fan_start_.begin(), fan_start_.end() - 1);
  for (std::int32_t t = 0; t < triangles_.rows(); ++t)
    for (int k = 0; k < 3; ++k) fan_[next[local_[triangles_(t, k)]]++] = t;
  normals_.assign(nodes_.size(), Vector3::Zero());
  areas_.assign(nodes_.size(), 0.0);
  look_everywhere();
}

void ContactSurface::look_everywhere() {
  std::vector<std::int32_t> all(static_cast<std::size_t>(triangles_.rows()));
  std::iota(all.begin(), all.end(), 0);
  look_at(std::move(all));
}

void ContactSurface::look_at(std::vector<std::int32_t> triangles) {
  require_indices("ContactSurface", "triangle",
                  Eigen::Map<const Indices>(triangles.data(), static_cast<std::ptrdiff_t>(triangles.size())),
                  triangles_.rows());
  shown_ = std::move(triangles);
  is_shown_.assign(static_cast<std::size_t>(triangles_.rows()), 0);
  std::vector<char> has_shown(nodes_.size(), 0);
  for (const std::int32_t t : shown_) {
    is_shown_[static_cast<std::size_t>(t)] = 1;
    for (const std::int32_t node : triangles_.row(t))
      has_shown[static_cast<std::size_t>(local_[static_cast<std::size_t>(node)])] = 1;
  }
  shown_nodes_.clear();
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    if (has_shown[i]) shown_nodes_.push_back(static_cast<std::int32_t>(i));
  rim_.assign(is_shown_.size(), 1);
  for (const std::int32_t t : shown_) {
    const auto corners = triangles_.row(t);
    rim_[static_cast<std::size_t>(t)] = std::any_of(corners.begin(), corners.end(), [&](std::int32_t node) {
      const auto around = fan(node);
      return std::any_of(around.begin(), around.end(),
                         [&](std::int32_t k) { return !is_shown_[static_cast<std::size_t>(k)]; });
    });
  }
  tree_.reset();
}

Eigen::Map<const Indices> ContactSurface::fan(std::int32_t node) const {
  const std::int32_t i = local_[static_cast<std::size_t>(node)];
  return {fan_.data() + fan_start_[i], fan_start_[i + 1] - fan_start_[i]};
}

double ContactSurface::mean_edge(const Points& x) const {
  double sum = 0;
  for (std::ptrdiff_t t = 0; t < triangles_.rows(); ++t)
    for (int k = 0; k < 3; ++k) sum += (x.row(triangles_(t, k)) - x.row(triangles_(t, (k + 1) % 3))).norm();
  return sum / static_cast<double>(3 * triangles_.rows());
}

void ContactSurface::update(const Points& x) {
  for (const std::int32_t i : shown_nodes_) {
    normals_[i].setZero();
    areas_[i] = 0.0;
  }
  for (const std::int32_t t : shown_) {
    const Vector3 a = x.row(triangles_(t, 0)), b = x.row(triangles_(t, 1)), c = x.row(triangles_(t, 2));
    const Vector3 twice_area = (b - a).cross(c - a);
    const double third = twice_area.norm() / 6.0;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t i = local_[triangles_(t, k)];
      normals_[i] += twice_area;
      areas_[i] += third;
    }
  }
  for (const std::int32_t i : shown_nodes_) normals_[i].normalize();
  if (tree_)
    tree_->update(triangles_, x);
  else
    tree_.emplace(triangles_, shown_, x);
}

const Vector3& ContactSurface::normal(std::int32_t node) const { return normals_[local_[node]]; }
double ContactSurface::tributary_area(std::int32_t node) const { return areas_[local_[node]]; }

double ContactSurface::bulge(std::int32_t node, const Points& x) const {
  const std::int32_t i = local_[node];
  double largest = 0;
  for (std::int32_t k = fan_start_[i]; k < fan_start_[i + 1]; ++k)
    for (const std::int32_t other : triangles_.row(fan_[k]))
      largest = std::max(largest, std::abs((x.row(other) - x.row(node)).dot(normals_[i])));
  return largest;
}

std::pair<double, double> ContactSurface::tributary_stretch(std::int32_t node, const Points& x) const {
  const double y = x(node, 1);
  double low = y, high = y;
  for (const std::int32_t triangle : fan(node))
    for (const std::int32_t other : triangles_.row(triangle)) {
      low = std::min(low, x(other, 1));
      high = std::max(high, x(other, 1));
    }
  return {0.5 * (y + low), 0.5 * (y + high)};
}

Vector3 ContactSurface::normal(const Foot& foot) const {
  Vector3 n = Vector3::Zero();
  for (int k = 0; k < 3; ++k) n += foot.weights[k] * normal(triangles_(foot.triangle, k));
  return n.normalized();
}

Foot ContactSurface::foot_on(const Points& x, const Vector3& p, std::int32_t triangle) const {
  const Vector3 a = x.row(triangles_(triangle, 0)), b = x.row(triangles_(triangle, 1)),
                c = x.row(triangles_(triangle, 2));
  Foot foot;
  foot.triangle = triangle;
  foot.weights = closest_weights(p, a, b, c);
  foot.squared_distance = (p - foot.weights[0] * a - foot.weights[1] * b - foot.weights[2] * c).squaredNorm();
  return foot;
}

Foot ContactSurface::closest(const Points& x, const Vector3& p, std::int32_t near) const {
  Foot best;
  best.squared_distance = std::numeric_limits<double>::infinity();
  if (near >= 0 && is_shown_[static_cast<std::size_t>(near)]) best = foot_on(x, p, near);
  tree_->near(p, best.squared_distance, [&](std::int32_t triangle) {
    const Foot foot = foot_on(x, p, triangle);
    if (foot.squared_distance < best.squared_distance ||
        (foot.squared_distance == best.squared_distance && triangle < best.triangle))
      best = foot;
    return best.squared_distance;
  });
  return best;
}

bool ContactSurface::within(const Points& x, const Vector3& p, double distance) const {
  bool found = false;
  tree_->near(p, distance * distance, [&](std::int32_t triangle) {
    found = found || foot_on(x, p, triangle).squared_distance <= distance * distance;
    return found ? -1.0 : distance * distance;  // one is enough
  });
  return found;
}

}  // namespace plica

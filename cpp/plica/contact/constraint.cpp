#include "plica/contact/constraint.hpp"

namespace plica {

Vector3 Constraint::offset(const Points& x) const {
  Vector3 d = Vector3::Zero();
  for (const auto& [node, weight] : weights) d += weight * x.row(node).transpose();
  return d;
}

bool Constraint::beside(const Points& x, double least) const {
  const Vector3 d = offset(x);
  const double along = gradient.dot(d);
  return d.norm() > least && 4 * along * along < d.squaredNorm() * gradient.squaredNorm();
}

double Constraint::residual(double p, const Points& x) const {
  return stiffness > 0 ? gap(x) + (p - multiplier) / stiffness : gap(x);
}

void Constraint::keep_direction(const Constraint& other) {
  weights = other.weights;
  normal = other.normal;
  gradient = other.gradient;
}

void Constraint::turn_towards(const Vector3& n) {
  const Vector3 between = (normal + n).normalized();
  if (2 * gradient.dot(between) >= gradient.norm()) normal = between;
}

Row Constraint::row(const Vector3& direction, double free) const {
  Row row;
  row.push.reserve(weights.size());
  row.gap.reserve(weights.size());
  for (const auto& [node, weight] : weights) {
    row.push.push_back({node, weight * normal});
    row.gap.push_back({node, weight * direction});
  }
  row.free = free;
  if (stiffness > 0) {
    row.free -= multiplier / stiffness;
    row.compliance = 1.0 / stiffness;
  }
  return row;
}

Row Constraint::slip_row(const Vector3& t, const Points& before, const Points& x_free) const {
  Row row;
  row.push.reserve(weights.size());
  for (const auto& [node, weight] : weights) row.push.push_back({node, weight * t});
  row.gap = row.push;
  row.free = t.dot(offset(x_free) - offset(before));
  return row;
}

}  // namespace plica

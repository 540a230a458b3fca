#include "plica/contact/facing_nodes.hpp"

#include <algorithm>

namespace plica {

FacingNodes::FacingNodes(const Detector& detector, const Points& reference) {
  constexpr double beside = 1e-3;  // mean edges, by which a node may lie beside the one that it faces
  const Vector3& facing = detector.airway().facing;
  if (detector.airway().renewed || !(facing.norm() > 0)) return;
  direction_ = facing.normalized();
  const ContactSurface &own = detector.slave_side(), &other = detector.master_side();
  double apart = 0;
  for (const std::int32_t slave : own.nodes()) {
    const std::int32_t master = detector.partner(slave);
    if (master < 0 || other.contains(slave) || own.contains(master)) continue;
    const Vector3 from_master = reference.row(slave) - reference.row(master);
    const double along = direction_.dot(from_master);
    if ((from_master - along * direction_).norm() > beside * detector.mean_edge()) continue;
    slaves_.push_back(slave);
    masters_.push_back(master);
    apart += along;
  }
  if (apart < 0) direction_ = -direction_;
}

Constraint FacingNodes::at(std::int32_t slave, const Points& x_before) const {
  const auto k =
      static_cast<std::size_t>(std::lower_bound(slaves_.begin(), slaves_.end(), slave) - slaves_.begin());
  Constraint constraint;
  constraint.key = constraint.slave = slave;
  constraint.weights = {{slave, 1.0}, {masters_[k], -1.0}};
  constraint.normal = constraint.gradient = direction_;
  constraint.depth = depth(k, x_before);
  return constraint;
}

std::vector<std::int32_t> FacingNodes::closer(const Points& x, const Points& x_before, double least) const {
  std::vector<std::int32_t> found;
  for (std::size_t k = 0; k < slaves_.size(); ++k)
    if (gap(k, x) + depth(k, x_before) < -least) found.push_back(slaves_[k]);
  return found;
}

double FacingNodes::deepest(const Points& x) const {
  double least = 0;
  for (std::size_t k = 0; k < slaves_.size(); ++k) least = std::min(least, gap(k, x));
  return least;
}

}  // namespace plica

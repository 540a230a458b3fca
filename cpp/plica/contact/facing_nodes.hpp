#pragma once
#include "plica/contact/pairs.hpp"

namespace plica {

/// Nodes of two surfaces that face each other at rest along a direction d, held apart along it: a force along d
/// and the gap d . (x_s - x_m), linear in the positions, so that there is exactly one solution, whatever shape the
/// surfaces are in. Of mirror images, d across their plane, it is that of exact contact: they overlap where one is
/// behind the plane. Of others it leaves out that facing nodes slide along each other where surfaces are inclined
/// to d. Nodes that are behind each other where a step begins are held as deep: to part them at a stroke would do
/// work which nothing pays for.
class FacingNodes {
 public:
  /// Of the detector's airway, where it is matched: each node with the one that faces it, those common to both
  /// surfaces left out. Empty in another airway.
  FacingNodes(const Detector& detector, const Points& reference);

  bool empty() const { return slaves_.empty(); }
  /// Of a step that begins at x_before.
  Constraint at(std::int32_t slave, const Points& x_before) const;
  /// The slaves whose gap, of a step that begins at x_before, is below -least (m) at x, ascending.
  std::vector<std::int32_t> closer(const Points& x, const Points& x_before, double least) const;
  /// m, <= 0: the least gap of all.
  double deepest(const Points& x) const;

 private:
  double gap(std::size_t k, const Points& x) const {
    return direction_.dot(x.row(slaves_[k]) - x.row(masters_[k]));
  }
  /// m, >= 0: how deep a pair may be.
  double depth(std::size_t k, const Points& x_before) const { return std::max(0.0, -gap(k, x_before)); }

  Vector3 direction_ = Vector3::Zero();         // unit, from the masters' tissue towards the slaves'
  std::vector<std::int32_t> slaves_, masters_;  // slaves ascending, on the detector's slave side
};

}  // namespace plica

#pragma once
#include "plica/contact/airway.hpp"

namespace plica {

/// Whether two surfaces that face each other are so far apart that nothing can touch, from the coordinates of a
/// reduction: while nodes that face each other are apart by more than twice what they have slid past each other.
class Clearance {
 public:
  /// Nodes at rest x (m, 3) m of an airway numbered so, moved by shapes (3 m, r); mean_edge (m) of its surfaces.
  Clearance(const Airway& airway, const Points& x, const Eigen::MatrixXd& shapes, double mean_edge);

  /// At coordinates q. Never where the airway does not say along which direction its nodes face each other.
  bool apart(const Vector& q);

 private:
  /// From the nodes of one surface to those that face them on the other, (3 p) m, in single precision.
  Eigen::VectorXf offsets(const Vector& q) const { return offsets_ + shapes_ * q.cast<float>(); }
  /// m, > 0 where at these offsets no air can be turned inside out: at least by how much the nodes of a pair are
  /// apart, over twice what they have slid. Where it is not, of the first such pair alone.
  float least(const Eigen::VectorXf& offsets) const;

  Vector3 facing_;
  float round_off_;          // m
  Eigen::VectorXf offsets_;  // (3 p) m, at rest
  Eigen::MatrixXf shapes_;   // (3 p, r)
  double speed_ = 0.0;       // of least(): at most so many times what coordinates change by
  Vector seen_at_;           // coordinates where least() was last computed,
  double seen_ = -1.0;       // m, and what it was
};

}  // namespace plica

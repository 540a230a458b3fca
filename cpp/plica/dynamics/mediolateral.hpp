#pragma once
#include "plica/dynamics/modal_motion.hpp"

namespace plica {

/// The mediolateral positions, x, of some nodes in the coordinates of a reduced motion: what section areas and the
/// contact of mirror images are made of. Of a symmetric motion the nodes are those of its part.
class Mediolateral {
 public:
  /// Nodes by their numbers in the motion's unknowns, the contact's first; they may repeat each other. The full
  /// motion must outlive it.
  Mediolateral(const Motion& full, const ModalMotion& motion, const std::vector<std::int32_t>& contact,
               const std::vector<std::int32_t>& others);

  std::ptrdiff_t size() const { return rest_.size(); }
  std::ptrdiff_t contact_size() const { return contact_panels_.rows(); }
  /// Where the x of a node of the mesh stands; it must be one of the nodes, or an image of one.
  std::int32_t place(std::int32_t node) const { return place_[static_cast<std::size_t>(own(node))]; }
  /// 1, or -1 where the node of the mesh has minus the x that stands there.
  double sign(std::int32_t node) const { return images_ ? images_->sign(node)[0] : 1.0; }
  const Vector& rest() const { return rest_; }               // (n) m, from the motion's origin
  const Eigen::MatrixXd& shapes() const { return shapes_; }  // (n, r)
  /// (n) m at coordinates (r); the same of two sets of them; and of the contact's nodes alone.
  Vector at(const Vector& q) const { return rest_ + panels_ * q; }
  TwoColumns at(const TwoColumns& q) const { return (panels_ * q).colwise() + rest_; }
  Vector contact_at(const Vector& q) const { return rest_.head(contact_size()) + contact_panels_ * q; }
  /// (n) m, what a change of the coordinates (r) adds.
  Vector change(const Vector& dq) const { return panels_ * dq; }

 private:
  std::int32_t own(std::int32_t node) const { return images_ ? images_->node_of(node) : node; }

  const MirrorImages* images_;  // null where all nodes move on their own
  std::vector<std::int32_t> place_;
  Vector rest_;
  Eigen::MatrixXd shapes_;
  PanelMatrix panels_, contact_panels_;
};

}  // namespace plica

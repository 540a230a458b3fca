#pragma once
#include "plica/contact/surface.hpp"
#include "plica/dynamics/contact_record.hpp"
#include "plica/dynamics/modal_motion.hpp"
#include "plica/dynamics/motion.hpp"

namespace plica {

/// One of two contact surfaces that are each other's mirror image in x = 0: that in x >= 0.
class MirroredSide {
 public:
  /// The motions, of a symmetric scene and of its coordinates, must outlive it. Throws InvalidInput for surfaces
  /// that are not each other's image.
  MirroredSide(const ContactPart& part, const Motion& full, const ModalMotion& motion);

  bool is_first() const { return is_first_; }                  // of the contact's two
  const ContactSurface& surface() const { return *surface_; }  // in the mesh's numbers
  /// Its nodes in the solved part that can move across the plane, ascending: not those in the plane nor others
  /// whose x is held. Throws InvalidInput where there is none.
  const std::vector<std::int32_t>& crossing() const { return crossing_; }
  /// m, of one of its nodes at coordinates q, from the motion's origin.
  Vector3 position(std::int32_t node, const Vector& q) const;
  /// What is pressed on it at coordinates q by forces (m) N on these nodes.
  std::vector<PressedNode> pressed(const Indices& nodes, const Vector& force, const Vector& q) const;

 private:
  const MirrorImages& images_;
  const Points& reference_;  // (n, 3) m
  bool is_first_;
  std::optional<ContactSurface> surface_;  // from construction on
  std::vector<std::int32_t> crossing_;
  Eigen::MatrixXd shapes_;           // (r, 3 nodes of the surface)
  std::vector<std::int32_t> place_;  // of a node of the mesh among these
};

}  // namespace plica

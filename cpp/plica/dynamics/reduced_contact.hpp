#pragma once
#include "plica/contact/collision.hpp"
#include "plica/dynamics/modal_motion.hpp"
#include "plica/dynamics/record.hpp"

namespace plica {

struct Reduction;

/// The contact of a scene as its coordinates see it. It numbers its own nodes, those of the surfaces within the
/// reduction's reach, from 0; positions (m, 3) of these are counted from the motion's origin.
class ReducedContact {
 public:
  /// The scene has contact and a reduction. response (r, s): accelerations per Pa at the sections of its airflow,
  /// empty without. All must outlive it. Throws InvalidInput for a contact that cannot be reduced.
  ReducedContact(const Scene& scene, const Motion& full, const ModalMotion& motion,
                 const Eigen::MatrixXd& response);

  const Collision& collision() const { return *collision_; }
  const Indices& nodes() const { return nodes_; }  // numbers in the mesh
  Points positions(const Vector& q) const;
  /// The same of coordinates that are asked for twice: where a step ends and the next begins.
  const Points& ends(const Vector& q);
  /// (m, 3) m/s^2, of section pressures (s) Pa.
  Points pressed(const Vector& pressure) const;
  /// From the nodes of one surface to those that face them on the other, (3 p) m, in single precision: at rest,
  /// the part of coordinates, and of section pressures.
  Eigen::VectorXf offsets(const Vector& q) const { return offsets_ + offset_shapes_ * q.cast<float>(); }
  Eigen::VectorXf offset_response(const Vector& pressure) const {
    return offset_response_ * pressure.cast<float>();
  }
  /// Whether at these offsets no air can be turned inside out: nodes that face each other are apart, by more than
  /// twice as much as they have slid past each other. False where it is not known which nodes do.
  bool apart(const Eigen::VectorXf& offsets) const;
  /// Phi^T f of forces (3 m) N.
  Vector forces(const Vector& nodal) const;

  void begin() { collision_->forget(); }
  /// As SceneContact::solve: forces that keep x_free, positions at t_{n+1} without them, apart; x: with them.
  Contacts solve(const BeforeContact& before, const Points& x_free, Contacts known, Points& x);
  /// What it did in a step from x_before to x, see contact_record. Throws SolveFailed where it has reached the
  /// rim.
  ContactRecord record(const Contacts& contacts, const Points& x_before, double depth, const Contact& now,
                       const Points& x);
  /// Throws SolveFailed where air beyond the reach is turned inside out at positions x (n, 3) of all nodes: the
  /// surfaces have passed through each other unseen.
  void require_open_beyond(const Points& x) const;
  /// Takes up a contact at x for pressure().
  void update_pressure(const Contact& contact, const Points& x);
  /// Takes up that nothing touches.
  void forget_pressure() { pressure_.resize(0); }
  /// (n) Pa at all nodes of the mesh, Collision::pressure.
  Vector pressure() const;

 private:
  const ModalMotion& motion_;
  std::ptrdiff_t mesh_nodes_;
  Indices nodes_;
  std::vector<char> rim_;  // (m)
  Tets beyond_;            // air that is not looked at, by numbers in the mesh
  Points reference_;
  Eigen::MatrixXd shapes_, response_at_nodes_;  // (3 m, r), (3 m, s)
  Vector3 facing_;
  Eigen::VectorXf offsets_;                          // (3 p) m, at rest
  Eigen::MatrixXf offset_shapes_, offset_response_;  // (3 p, r), (3 p, s)
  Vector end_;                                       // coordinates of the last ends()
  Points at_end_;
  Supports held_;
  std::unique_ptr<const LinearSolver> response_;
  std::optional<Collision> collision_;  // from construction on
  Vector pressure_;                     // (m) Pa
};

}  // namespace plica

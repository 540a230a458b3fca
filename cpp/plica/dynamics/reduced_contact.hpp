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
  /// The scene has contact and a reduction. All must outlive it. Throws InvalidInput for a contact that cannot be
  /// reduced.
  ReducedContact(const Scene& scene, const Motion& full, const ModalMotion& motion);

  const Collision& collision() const { return *collision_; }
  const Indices& nodes() const { return nodes_; }  // numbers in the mesh
  Points positions(const Vector& q) const { return reference_ + moved(q); }
  /// (m, 3) m, of coordinates.
  Points moved(const Vector& q) const;
  /// Phi^T f of forces (3 m) N.
  Vector forces(const Vector& nodal) const;

  void begin() { collision_->forget(); }
  /// As SceneContact::solve: forces that keep x_free, positions at t_{n+1} without them, apart; x: with them.
  Contacts solve(const BeforeContact& before, const Points& x_free, Contacts known, Points& x);
  /// What it did in a step to x, see contact_record. Throws SolveFailed where it has reached the rim.
  ContactRecord record(const Contacts& contacts, const Points& x_before, double depth, const Contact& now,
                       const Points& x);
  /// Takes up a contact at x for pressure().
  void update_pressure(const Contact& contact, const Points& x);
  /// (n) Pa at all nodes of the mesh, Collision::pressure.
  Vector pressure() const;

 private:
  const ModalMotion& motion_;
  std::ptrdiff_t mesh_nodes_;
  Indices nodes_;
  std::vector<char> rim_;  // (m)
  Points reference_;
  Eigen::MatrixXd shapes_;  // (3 m, r)
  Supports held_;
  std::unique_ptr<const LinearSolver> response_;
  std::optional<Collision> collision_;  // from construction on
  Vector pressure_;                     // (m) Pa
};

}  // namespace plica

#pragma once
#include "plica/contact/collision.hpp"
#include "plica/dynamics/clearance.hpp"
#include "plica/dynamics/reduced_contact.hpp"

namespace plica {

/// Contact between two surfaces, detected as that of the full scene. It numbers its own nodes, those of the
/// surfaces within the reduction's reach, from 0; positions (m, 3) of these are counted from the motion's origin.
class ReducedCollision final : public ReducedContact {
 public:
  /// See reduced_contact.
  ReducedCollision(const Scene& scene, const Motion& full, const ModalMotion& motion,
                   const Mediolateral& positions);

  void begin(const State& last) override;
  void touch(const FreeEnd& free) override;
  const Vector& x_acceleration() const override { return x_acceleration_; }
  Vector load() const override { return load_; }
  Vector acceleration() const override { return acceleration_; }
  Vector interface_force() const override { return force_; }
  std::pair<std::vector<std::int32_t>, Vector> closed() const override { return contacts_.closed(); }
  bool knows(std::int32_t key) const override { return collision_->knows(key); }
  bool anywhere(const std::function<bool(const Vector3&)>& place) const override;
  ContactRecord record(const State& now) override;
  void restore(const State& state) override;
  Vector pressure() const override;
  Vector force(const Vector& interface_force) const override;
  void require_open_beyond(const Points& x) const override;

 private:
  Points positions(const Vector& q) const;
  /// The same of coordinates that are asked for twice: where a step ends and the next begins.
  const Points& ends(const Vector& q);
  Contacts solve(const BeforeContact& before, const Points& x_free, Points& x);

  const ModalMotion& motion_;
  const Mediolateral& mediolateral_;
  std::ptrdiff_t mesh_nodes_;
  std::vector<char> rim_;  // (m)
  Tets beyond_;            // air that is not looked at, by numbers in the mesh
  Points reference_;
  Eigen::MatrixXd shapes_;  // (3 m, r)
  PanelMatrix panels_;      // the same
  Supports held_;
  std::unique_ptr<const LinearSolver> response_;
  // From construction on.
  std::optional<Collision> collision_;
  std::optional<Clearance> clearance_;
  Vector pressure_;  // (m) Pa, empty where nothing touches
  Vector end_;       // coordinates of the last ends()
  Points at_end_;

  // Of the step.
  const State* last_ = nullptr;
  bool near_ = false, never_near_ = true;  // in its last move, in no move so far
  Points x_before_, x_;
  Contacts contacts_;
  Vector load_, acceleration_, x_acceleration_, force_;
};

}  // namespace plica

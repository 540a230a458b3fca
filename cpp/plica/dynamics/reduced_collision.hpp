#pragma once
#include "plica/contact/collision.hpp"
#include "plica/dynamics/modal_force_solver.hpp"
#include "plica/dynamics/proximity.hpp"
#include "plica/dynamics/reduced_contact.hpp"

namespace plica {

/// Contact between two surfaces, detected as that of the full scene, but looked for only where it can be
/// (Proximity). It numbers its own nodes, those of the surfaces, from 0; positions (m, 3) of these are counted
/// from the motion's origin, and up to date at the nodes looked at.
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
  void require_open_beyond(const State& now, const Points& x) override;

 private:
  double inertia() const { return motion_.scheme().inertia(motion_.step()); }
  /// Positions of the nodes looked at, in their places of x, at the coordinates of the step's first move.
  void take_first_positions();
  /// The same at coordinates that are asked for twice: where a step ends and the next begins.
  const Points& ends(const Vector& q);
  /// Looks at what is near at coordinates q and within `ahead` (m) more of motion, and rings of triangles around.
  void look(const Vector& q, double ahead, int rings);
  /// Restricts the detector and the solver of forces to that.
  void show_near();
  void look_everywhere();
  /// Looks anew unless the last look holds at q, and reckons with as many moves to come as the last one lasted.
  void keep_in_sight(const Vector& q);
  /// The contacts of a move that leads to `free` without them, from those known of the move before.
  Contacts solve(const Vector& free, Contacts known);

  const ModalMotion& motion_;
  const Mediolateral& mediolateral_;
  std::ptrdiff_t mesh_nodes_;
  bool single_;    // whether the tolerance of contact leaves single precision enough for the moves of a step
  bool by_nodes_;  // whether keys of constraints are nodes
  Points reference_;
  RowMajorMatrix shapes_;  // (3 m, r)
  // From construction on.
  ModalForceSolver* force_solver_ = nullptr;  // the collision's
  std::optional<Collision> collision_;
  std::optional<Proximity> proximity_;
  std::optional<Detector> everywhere_detector_;  // of require_open_beyond
  Vector watched_;                               // coordinates of the last of these
  // What is looked at.
  MovedNodes seen_;
  bool everywhere_ = false;
  bool shown_is_near_ = false;  // what was found near by the last look
  int rings_ = 1;
  double ahead_ = 0.0;  // m
  int moves_ = 0;       // since the last look, where something could touch
  Vector pressure_;     // (m) Pa, empty where nothing touches
  Vector end_;          // coordinates of the last ends()
  Points at_end_;

  // Of the step.
  const State* last_ = nullptr;
  bool near_ = false, never_near_ = true;  // in its last move, in no move so far
  Points x_before_, x_first_, x_free_, x_;
  Vector first_free_;   // coordinates of x_first_, of the step's first move that was looked at; empty before
  double reach_ = 0.0;  // m, of the last move, at its end
  Contacts contacts_;
  Vector load_, acceleration_, x_acceleration_, force_;
};

}  // namespace plica

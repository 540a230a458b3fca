#pragma once
#include <functional>
#include <memory>

#include "plica/dynamics/modal_motion.hpp"
#include "plica/dynamics/record.hpp"
#include "plica/dynamics/state.hpp"

namespace plica {

/// The contact of a scene as the coordinates of its reduction see it. In a step it is told where that would end
/// without contact, and asked for each move of the coupling what keeps the surfaces apart.
class ReducedContact {
 public:
  virtual ~ReducedContact() = default;

  /// Its own nodes, by their numbers in the mesh: a state's interface_force is on these.
  const Indices& nodes() const { return nodes_; }

  /// A step begins from `last`, which must live as long as it.
  virtual void begin(const State& last) = 0;
  /// Finds the forces of a move that without them leads to the displacement `free` (r) at t_{n+1}.
  virtual void touch(const Vector& free) = 0;

  // Of the last move.
  bool touches() const { return touches_; }
  const Vector& load() const { return load_; }                  // (r), Phi^T of the forces
  const Vector& acceleration() const { return acceleration_; }  // (r), A^-1 of that
  const Vector& interface_force() const { return force_; }      // (3 nodes) N
  /// What carries force, keys ascending, and its forces (N).
  virtual std::pair<std::vector<std::int32_t>, Vector> closed() const = 0;
  /// Whether there can be a constraint of this key.
  virtual bool knows(std::int32_t key) const = 0;
  /// Whether it, or edges that cross, lie at a place (m, from the motion's origin) where this says so.
  virtual bool anywhere(const std::function<bool(const Vector3&)>& place) const = 0;

  /// What it did in the step from the last state to `now`. Throws SolveFailed where it has reached the rim of
  /// where it is looked for.
  virtual ContactRecord record(const State& now) = 0;
  /// Takes up a state, for pressure().
  virtual void restore(const State& state) = 0;
  /// (n) Pa at all nodes of the mesh, Collision::pressure.
  virtual Vector pressure() const = 0;
  /// (3 n) N of the forces on its own nodes.
  virtual Vector force(const Vector& interface_force) const = 0;
  /// Throws SolveFailed where, at positions x (n, 3) of all nodes, surfaces have passed through each other where
  /// it is not looked for.
  virtual void require_open_beyond(const Points& x) const = 0;

 protected:
  Indices nodes_;
  bool touches_ = false;
  Vector load_, acceleration_, force_;
};

/// Between the mirror images of a symmetric scene (MirrorContact), else between surfaces (ReducedCollision). All
/// must outlive it. Throws InvalidInput for a contact that cannot be reduced.
std::unique_ptr<ReducedContact> reduced_contact(const Scene& scene, const Motion& full, const ModalMotion& motion);

}  // namespace plica

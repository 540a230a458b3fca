#pragma once
#include <functional>
#include <memory>

#include "plica/dynamics/mediolateral.hpp"
#include "plica/dynamics/record.hpp"
#include "plica/dynamics/state.hpp"

namespace plica {

/// Where a move of a step leads without contact, at t_{n+1}.
class FreeEnd {
 public:
  virtual ~FreeEnd() = default;
  virtual const Vector& contact_x() const = 0;  // (c) m, of Mediolateral's contact nodes
  virtual Vector free_end() const = 0;          // (r), computed anew
};

/// The contact of a scene in the coordinates of its reduction. For each move of the coupling within a step it
/// finds the forces that keep the surfaces apart.
class ReducedContact {
 public:
  virtual ~ReducedContact() = default;

  /// Its own nodes, by their numbers in the mesh: a state's interface_force is on these.
  const Indices& nodes() const { return nodes_; }

  /// A step begins from `last`, which must live as long as it.
  virtual void begin(const State& last) = 0;
  /// Finds the forces of a move, which must live until the next one or the end of the step.
  virtual void touch(const FreeEnd& free) = 0;

  // Of the last move.
  bool touches() const { return touches_; }
  virtual const Vector& x_acceleration() const = 0;  // (n) m/s^2 of Mediolateral's nodes; where it touches
  virtual Vector load() const = 0;                   // (r), Phi^T of the forces
  virtual Vector acceleration() const = 0;           // (r), A^-1 of that
  virtual Vector interface_force() const = 0;        // (3 nodes) N
  /// What carries force, keys ascending, and its forces (N).
  virtual std::pair<std::vector<std::int32_t>, Vector> closed() const = 0;
  /// Whether there can be a constraint of this key.
  virtual bool knows(std::int32_t key) const = 0;
  /// Whether it, or edges that cross, lie at a place (m, from the motion's origin) where this says so.
  virtual bool anywhere(const std::function<bool(const Vector3&)>& place) const = 0;

  /// What it did in the step from the last state to `now`.
  virtual ContactRecord record(const State& now) = 0;
  /// Takes up a state, for pressure().
  virtual void restore(const State& state) = 0;
  /// (n) Pa at all nodes of the mesh, Collision::pressure.
  virtual Vector pressure() const = 0;
  /// (3 n) N of the forces on its own nodes.
  virtual Vector force(const Vector& interface_force) const = 0;
  /// Throws SolveFailed where in a state, at positions x (n, 3) of all nodes, surfaces have passed through each
  /// other where it was not looked for.
  virtual void require_open_beyond(const State& now, const Points& x) = 0;

 protected:
  Indices nodes_;
  bool touches_ = false;
};

/// Between the mirror images of a symmetric scene (MirrorContact), else between surfaces (ReducedCollision). All
/// must outlive it; of a symmetric scene `positions` has those of the contact's surfaces. Throws InvalidInput for
/// a contact that cannot be reduced.
std::unique_ptr<ReducedContact> reduced_contact(const Scene& scene, const Motion& full, const ModalMotion& motion,
                                                const Mediolateral& positions);

}  // namespace plica

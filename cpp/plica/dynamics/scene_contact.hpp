#pragma once
#include "plica/contact/collision.hpp"
#include "plica/dynamics/motion.hpp"
#include "plica/dynamics/record.hpp"
#include "plica/dynamics/tissue_overlap.hpp"
#include "plica/tissue/node_stress.hpp"

namespace plica {

class SceneFlow;
class Step;

/// The contact of a scene as its steps see it, positions (n, 3) m from the motion's origin.
class SceneContact {
 public:
  /// The scene has contact; it and the motion must outlive this. Throws InvalidInput.
  SceneContact(const Scene& scene, const Motion& motion);

  Collision& collision() { return *collision_; }
  const Collision& collision() const { return *collision_; }
  /// Those whose positions it looks at, the airflow's among them.
  const Indices& nodes() const { return nodes_; }
  /// How contact forces are solved for, never Automatic; absent in explicit steps, which solve for nothing.
  const std::optional<ContactSolver>& solver() const { return solver_; }

  /// Throws InvalidInput where surfaces overlap at t = 0, x: they would be thrown apart by a force that nothing
  /// has done work for.
  void require_apart(const Points& x);
  /// A step begins at x, the surfaces being `depth` (m) deep in each other: forgets the steps before.
  void begin(const Points& x, double depth);
  /// The contacts of a step whose x() is without them; on return x holds it with. known: see Collision::solve.
  Contacts solve(const Step& step, Contacts known, Points& x);
  /// The contacts of an explicit step from the state `last` at x_previous: x is where it ends.
  Contacts forces_at(const Points& x, const Points& x_previous, const State& last);
  /// Whether these contacts at x, or edges that cross there, lie in the middle of the glottis and can stop the
  /// flow; the step began at x_previous with surfaces `depth` (m) deep in each other.
  bool blocks(const SceneFlow& flow, const Contacts& contacts, const Points& x, const Points& x_previous,
              double depth) const;
  /// What these contacts did in a step from x_previous and `depth` that ended in the state `now` at x; folded:
  /// whether tissue cells are.
  ContactRecord record(const Contacts& contacts, const Points& x_previous, double depth, const State& now,
                       const Points& x, bool folded);
  /// Takes up a state at x for pressure().
  void update_pressure(const State& state, const Points& x);
  /// (n) Pa, Collision::pressure; empty before the first state.
  const Vector& pressure() const { return pressure_; }

 private:
  const Scene& scene_;
  const Motion& motion_;
  std::optional<NodeStress> node_stress_;  // where the method sees the tissue's stress
  Indices nodes_;
  std::optional<ContactSolver> solver_;
  std::optional<Collision> collision_;    // from construction on
  std::optional<TissueOverlap> overlap_;  // likewise
  Vector pressure_;                       // (n) Pa
};

}  // namespace plica

#pragma once
#include "plica/contact/contacts.hpp"
#include "plica/dynamics/coupling.hpp"
#include "plica/dynamics/state.hpp"

namespace plica {

/// One step in the making of a motion of nodes, implicit (Step) or explicit (ExplicitStep). A coupling moves it as
/// often as it needs; complete() then finds its acceleration, end() the state that it leads to.
class NodalStep : public CoupledStep {
 public:
  using CoupledStep::move;
  /// Moves it under the scene's load alone.
  virtual void move() = 0;
  /// Whether the tissue's force where it has been moved is the one that it was moved under; else takes another,
  /// and it is to be moved again. Linear tissue's always is.
  virtual bool settle() { return true; }
  /// Where a move has failed: whether there is a force of the tissue under which it may not.
  virtual bool retreat() { return false; }
  /// How often that force has been evaluated.
  virtual int evaluations() const { return 0; }
  /// Finds the acceleration under the loads and contact forces of the last move.
  virtual void complete() = 0;
  /// The state that the completed step leads to, its ledger, first signs and memory of the air still those of the
  /// last; takes what it needs out of the step. Its past is empty.
  virtual State end() = 0;
  /// A a of the completed step's acceleration; empty where nothing was solved for.
  virtual Vector take_image() = 0;
  virtual const Contacts& contacts() const = 0;
  /// (n, 3) m at t_n, from the motion's origin; those that neither flow nor contact see may be left out.
  virtual const Points& x_previous() const = 0;
  /// Of the linear solver.
  virtual int iterations() const = 0;
};

}  // namespace plica

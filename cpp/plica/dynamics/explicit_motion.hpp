#pragma once
#include <memory>

#include "plica/dynamics/motion.hpp"
#include "plica/dynamics/nodal_step.hpp"
#include "plica/dynamics/slope_watch.hpp"

namespace plica {

class SceneContact;
class SceneFlow;

/// Central differences in the place of a Step: positions of t_{n+1} follow from the state, so flow and contact act
/// at shapes that are known, nothing is solved for and a coupling has nothing to iterate
/// (docs/theory/explicit.md).
class ExplicitMotion {
 public:
  /// The motion must outlive it. Throws InvalidInput for a mass that is not lumped, for what of the scene takes a
  /// solve, and for a step above the largest stable one.
  ExplicitMotion(const Scene& scene, const Motion& motion);

  /// s, with the stiffness of the scene's penalty, every node of the surfaces being in contact; of tissue at
  /// finite strain with its slopes at the shape of the mesh.
  double largest_step() const { return stable_.largest(contact_stiffness_); }

  /// Completes a state of t = 0, whose displacement, velocity and load are given. Throws InvalidInput where tissue
  /// at finite strain is inside out, or too stiff for the step, there.
  void begin(State& state);
  /// After begin() and each step.
  Ledger opened_ledger(const State& state) const;
  Ledger continued_ledger(const State& before, const State& now) const;

  /// From the state `last` under scene_load (3 n) N at t_{n+1}; flow and contact are null where there is none.
  /// All must outlive it. Throws SolveFailed where closed contacts, or tissue at finite strain, are too stiff for
  /// the step.
  std::unique_ptr<NodalStep> step(const State& last, Vector scene_load, const SceneFlow* flow,
                                  SceneContact* contact, StepTimes& times);

 private:
  friend class ExplicitStep;
  /// At the displacement of the state that is being made.
  void require_stable(const State& now, const Contacts& contacts);
  /// a, v, M a, K u and C V of a state whose u and v^ are given and whose forces are known, at finite strain with
  /// its excess forces.
  void accelerate(const State& last, const Vector& velocity, State& now) const;
  Vector momentum(const Vector& velocity) const;

  const Motion& motion_;
  Vector mass_, inverse_mass_;  // (3 n) kg, 1/kg; the latter zero where held
  StableStep stable_;
  double contact_stiffness_ = 0.0;   // 1/s^2
  double eigenvalue_;                // of the step
  std::optional<SlopeWatch> watch_;  // at finite strain
};

}  // namespace plica

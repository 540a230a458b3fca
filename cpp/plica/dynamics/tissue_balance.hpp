#pragma once
#include <functional>

#include "plica/dynamics/finite_strain.hpp"
#include "plica/solve/linear_solver.hpp"

namespace plica {

/// The balance of a step whose tissue is at finite strain: A a = b(a) - r(a), b what the coupling and contact make
/// of it, r the ExcessForce where a leads. An r is that of a guess y; the step gives back the a that it moves with
/// under that, and A a; the next guess is the affine combination of the last a whose residuals A (a - y) cancel
/// best, in the energy a . A a (Anderson). Settled where the residual, which is what is out of balance at y, is
/// small.
class TissueBalance {
 public:
  /// U and V of a step's equation under an acceleration.
  using Weighted = std::function<void(const Vector& a, Vector& U, Vector& V)>;
  /// Begins with the force of `first`, A first.x being first.product; where a cell has none there, nearer to
  /// `still`, the acceleration under which nothing moves. Throws SolveFailed.
  TissueBalance(const ExcessForce& law, Weighted weighted, Guess first, std::function<Guess()> still);

  /// r of now.
  const ExcessForce::Force& force() const { return force_; }
  const Vector& sum() const { return sum_; }
  /// How often a force has been evaluated.
  int evaluations() const { return evaluations_; }
  /// Whether `reached`, with A of it, is what the force of now leads to; else takes the next. Throws SolveFailed
  /// where iterations run out, or no guess has a force.
  bool settled(Guess reached);
  /// Where the force of now leads nowhere: takes that of a guess nearer to the best one so far. False where that
  /// has been of no use.
  bool retreat();

 private:
  /// Takes the force of a guess, or of one nearer to the best, where a cell has none.
  void take(Guess guess);
  const Guess& best();
  Guess mixed() const;

  const ExcessForce& law_;
  Weighted weighted_;
  std::function<Guess()> still_;
  Guess guess_;
  Guess best_;    // of those that led somewhere, the one with the least residual; first: still
  double least_;  // g . A g of it
  ExcessForce::Force force_;
  Vector sum_;
  std::vector<Guess> reached_, residual_;  // newest last: a with A a, a - y with A (a - y)
  int evaluations_ = 0, iterations_ = 0, retreats_ = 0;
};

}  // namespace plica

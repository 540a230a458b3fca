#pragma once
#include "plica/solve/triangular_factor.hpp"

namespace plica {

/// A x = b for `pack` right-hand sides at once, A symmetric positive definite and constrained by Supports: the
/// factor in single precision with refinement in double until every lane's |b - A x| / |b| is `tolerance`, or
/// within 1e-10 no longer falls.
class PackedSolver {
 public:
  /// A must outlive it. Throws SolveFailed where A is not positive definite.
  PackedSolver(const BlockMatrix& A, double tolerance) : A_(A), factor_(A, FactorPlan(A)), tolerance_(tolerance) {}

  /// b, x [pack * unknown + lane]; `step` names the step in the message of SolveFailed.
  void solve(const std::vector<double>& b, std::vector<double>& x, std::ptrdiff_t step) const;

 private:
  const BlockMatrix& A_;
  TriangularFactor factor_;
  double tolerance_;
};

}  // namespace plica

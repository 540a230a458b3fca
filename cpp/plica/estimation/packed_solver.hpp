#pragma once
#include <array>

#include "plica/solve/triangular_factor.hpp"

namespace plica {

/// A x = b for `pack` right-hand sides at once, A symmetric positive definite and constrained by Supports: the
/// factor in single precision with refinement in double until every lane's |b - A x| / |b| is `tolerance`, or
/// within 1e-10 no longer falls.
class PackedSolver {
 public:
  using Lanes = std::array<double, TriangularFactor::pack>;

  /// A must outlive it. Throws SolveFailed where A is not positive definite.
  PackedSolver(const BlockMatrix& A, double tolerance) : A_(A), factor_(A, FactorPlan(A)), tolerance_(tolerance) {}

  /// b, x [pack * unknown + lane]; starts from x, which a lane gives up where it is worse than zero. `step` names
  /// the step in the message of SolveFailed.
  void solve(const std::vector<double>& b, std::vector<double>& x, std::ptrdiff_t step) const;

 private:
  /// r = b - A x; returns |r|^2 of each lane.
  Lanes residual(const std::vector<double>& b, const std::vector<double>& x, std::vector<double>& r) const;

  const BlockMatrix& A_;
  TriangularFactor factor_;
  double tolerance_;
};

}  // namespace plica

#pragma once
#include "plica/solve/krylov.hpp"

namespace plica {

/// A row of a saddle point: a column of N^T, a row of G, and its entries of D and g.
struct SaddleRow {
  std::vector<NodeVector> push, gap;
  double compliance = 0.0;  // >= 0
  double value = 0.0;
};

/// Few constraints on many unknowns,
///
///   [A  N^T] [d     ]   [0]
///   [G  -D ] [lambda] = [g],   A symmetric positive definite, D >= 0 diagonal,
///
/// where G and N are equal or nearly so. Conjugate gradients on the symmetric system, G = N, with the constraint
/// preconditioner [B^-1 N^T; N -D], B the inverse of A's 3x3 diagonal blocks: its iterates obey the constraints
/// exactly, so it needs as many iterations as A alone; A is rounded to single precision. That is the
/// preconditioner of generalised conjugate residuals on the system itself, which take up the difference of G from
/// N and of A from its rounding: three or four of them. docs/theory/contact_solve.md.
class SaddlePoint {
 public:
  /// A must outlive it and not change. Throws SolveFailed where a diagonal block is not positive definite.
  SaddlePoint(const BlockMatrix& A, KrylovOptions options);

  /// Starts from d (n) and lambda (m). A shared_compliance of the largest diagonal entry of N B N^T is added to D,
  /// so that rows that depend on others share the force. The residual is taken over that of [0; g] in the norm
  /// |r|^2 = sum r_i^2 / diag(A) + sum r_i^2 / diag(N B N^T + D); iterations count products with A. Throws
  /// SolveFailed where no row pushes anything, or a number is not finite.
  Convergence solve(const std::vector<SaddleRow>& constraints, Vector& d, Vector& lambda) const;

 private:
  struct System;
  struct Both;
  int correct(const System& system, const Both& right, Both& x, double target, bool rounded) const;

  const BlockMatrix& A_;
  ConjugateGradient blocks_;  // for B and A rounded
  KrylovOptions options_;
  Vector weight_;  // (n) 1 / diag(A)
};

}  // namespace plica

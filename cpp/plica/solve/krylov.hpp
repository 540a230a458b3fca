#pragma once
#include <functional>
#include <mutex>

#include "plica/core/block_matrix.hpp"

namespace plica {

/// How an iteration ended; a caller may look at it, so it is data.
struct Convergence {
  int iterations = 0;
  double residual = 0.0;  // |b - A x| / |b|
  bool converged = false;
};

struct KrylovOptions {
  double tolerance = 1e-8;    // on |b - A x| / |b|, in (0, 1)
  int max_iterations = 2000;  // >= 1
  void validate() const;
};

/// Conjugate gradients with 3x3 block-Jacobi preconditioning, warm-started from x. A symmetric positive
/// definite, constrained by Supports. Threaded, the same result for any number of threads.
/// The iteration works on A rounded to single precision, half the bytes of a product that memory limits; the
/// residual is then taken with A itself, and what is left is solved for again (iterative refinement), so the
/// tolerance holds for A. Where the rounded matrix is too coarse for that (badly conditioned A: it stagnates above
/// the tolerance or is not positive definite), A itself finishes. Per iteration one product and five passes over
/// vectors.
class ConjugateGradient {
 public:
  /// A must outlive it; its diagonal blocks are read here, so it must not change afterwards. Throws SolveFailed
  /// where a diagonal block is not positive definite.
  ConjugateGradient(const BlockMatrix& A, KrylovOptions options);
  /// Starts from x (3 n), or from zero where x is empty. b = 0 gives x = 0. Throws SolveFailed where A shows
  /// itself not positive definite (p^T A p <= 0) or a number is not finite.
  Convergence solve(const Vector& b, Vector& x, double tolerance) const;
  Convergence solve(const Vector& b, Vector& x) const { return solve(b, x, options_.tolerance); }
  /// Solves for k right-hand sides (3 n, k) together: each product reads A once for all of them; each
  /// column takes the same arithmetic whatever its company. X starts from zero. In double precision throughout;
  /// Convergence::residual is the recursion's, which differs from |b - A x| / |b| by accumulated round-off.
  std::vector<Convergence> solve_many(const Eigen::MatrixXd& B, Eigen::MatrixXd& X, double tolerance) const;
  std::vector<Convergence> solve_many(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) const {
    return solve_many(B, X, options_.tolerance);
  }
  const KrylovOptions& options() const { return options_; }
  /// z = (3x3 diagonal blocks)^-1 r
  void precondition(const Vector& r, Vector& z) const;
  /// The node rows [begin, end) of that alone, and of q = A p with A rounded to single precision, for loops that
  /// do more to those rows; r, z, p, q (3 n).
  void precondition_rows(std::ptrdiff_t begin, std::ptrdiff_t end, const Vector& r, Vector& z) const;
  void multiply_rounded_rows(std::ptrdiff_t begin, std::ptrdiff_t end, const Vector& p, Vector& q) const;

 private:
  const BlockMatrix* A_;
  KrylovOptions options_;
  /// Solves A d = r to |r - A d| <= target |r| with q = A p from product(begin, end, p, q) on node rows; r becomes
  /// the recursion's residual. Stops where p^T A p is not positive and finite, and returns the last one.
  template <typename Product>
  double correct(const Product& product, Vector& r, Vector& d, double target, Convergence& state) const;

  void make_single() const;

  mutable std::once_flag single_made_;
  mutable std::vector<float> single_;  // (9 entries) A rounded, made when first needed
  std::vector<double> inverse_;        // (6 n) entries 00, 01, 02, 11, 12, 22 of the inverse diagonal blocks
};

/// Restarted GMRES with modified Gram-Schmidt for y = operator(x), left and right preconditioned by the
/// square root of a positive diagonal: the thesis's Eq. (29) applied "at both sides". Warm-started from x
/// (or from zero where x is empty). With S = diagonal^(-1/2) it solves (S Op S) y = S b, x = S y; tolerance and
/// Convergence::residual are |S (b - Op x)| / |S b|, the latter recomputed from x at the end of every cycle.
/// Iterations count products in the Krylov space. A cycle that does not lower the residual ends it unconverged.
/// Throws SolveFailed where a number is not finite.
Convergence gmres(const std::function<void(const Vector&, Vector&)>& apply, const Vector& diagonal,
                  const Vector& b, Vector& x, const KrylovOptions& options, int restart = 50);

}  // namespace plica

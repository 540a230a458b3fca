#pragma once
#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <variant>

#include "plica/solve/krylov.hpp"

namespace plica {

/// Where a solve starts, and after it where it has ended.
struct Guess {
  Vector x;        // (3 n); empty: zero
  Vector product;  // A x, where it is known; empty where not
};

/// Ways to solve a linear system.
namespace linear {

/// By a sparse Cholesky factor in single precision with iterative refinement: each refinement takes one solve with
/// the factor, one product with A in double precision. One refinement lowers the residual by some 1e-6 where the
/// step is short; where it lowers it by less than ten, conjugate gradients preconditioned by the factor go on.
struct Cholesky {
  int max_iterations = 200;  // solves with the factor, >= 1
};
/// As ConjugateGradient: nothing but A rounded is kept.
struct ConjugateGradients {
  int max_iterations = KrylovOptions{}.max_iterations;  // >= 1
};
/// Cholesky where its factor takes no more than `memory` and its solves move no more bytes than conjugate
/// gradients do, whose iterations are counted in a solve; ConjugateGradients otherwise. The factorisation takes
/// the time of some hundred solves, which a run of thousands of steps repays.
struct Automatic {
  double memory = 1e9;  // bytes of the factor, >= 0
};

}  // namespace linear

/// Solves A x = b for one A, symmetric positive definite and constrained by Supports, and many b.
class LinearSolver {
 public:
  using Automatic = linear::Automatic;
  using Cholesky = linear::Cholesky;
  using ConjugateGradients = linear::ConjugateGradients;
  using Method = std::variant<Automatic, Cholesky, ConjugateGradients>;
  struct Options {
    double tolerance = KrylovOptions{}.tolerance;  // on |b - A x| / |b|, in (0, 1)
    Method method = Automatic{};
    void validate() const;  // throws InvalidInput
    /// For what is solved by a Krylov method whatever is chosen here.
    KrylovOptions krylov() const;
  };

  /// A must outlive the solver and not change. Throws SolveFailed where A is found not to be positive definite.
  static std::unique_ptr<const LinearSolver> make(const BlockMatrix& A, const Options& options);
  virtual ~LinearSolver() = default;

  /// Writes A x.
  using Product = std::function<void(const Vector& x, Vector& image)>;
  /// Starts from guess.x and leaves the solution there. b = 0 gives x = 0. `product`: of A in double precision,
  /// for callers that keep more of it than A x; the last one is the solution's, and left in the guess. Throws
  /// SolveFailed where A shows itself not positive definite or a number is not finite.
  virtual Convergence solve(const Vector& b, Guess& guess, double tolerance, const Product& product) const = 0;
  /// The product is left in the guess where it comes free.
  virtual Convergence solve(const Vector& b, Guess& guess, double tolerance) const = 0;
  Convergence solve(const Vector& b, Guess& guess) const { return solve(b, guess, tolerance()); }
  /// Solves for k right-hand sides (3 n, k) from zero, to a tolerance of their own; each column takes the same
  /// arithmetic whatever its company. Cheapest in blocks of `pack`. The residual of conjugate gradients is that of
  /// their recursion, not b - A x taken anew.
  virtual std::vector<Convergence> solve_many(const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                                              double tolerance) const = 0;
  static constexpr int pack = BlockMatrix::pack;
  virtual std::string name() const = 0;
  virtual double tolerance() const = 0;
  /// Enough for what only positions within a step follow from, of which contact and flow ask some 1e-4 of a step's
  /// motion: the step is solved for to tolerance() once these are known.
  double tolerance_of_positions() const { return std::min(1e-6, 100 * tolerance()); }
};

}  // namespace plica

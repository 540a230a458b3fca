#include "plica/solve/linear_solver.hpp"

#include <cmath>

#include "plica/core/error.hpp"
#include "plica/solve/cholesky_solver.hpp"

namespace plica {
namespace {

class IterativeSolver : public LinearSolver {
 public:
  IterativeSolver(const BlockMatrix& A, const KrylovOptions& options) : solver_(A, options) {}
  using LinearSolver::solve;
  Convergence solve(const Vector& b, Guess& guess, double tolerance) const override {
    guess.product = Vector();
    return solver_.solve(b, guess.x, tolerance);
  }
  Convergence solve(const Vector& b, Guess& guess, double tolerance, const Product& product) const override {
    const Convergence end = solve(b, guess, tolerance);
    product(guess.x, guess.product);
    return end;
  }
  std::vector<Convergence> solve_many(const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                                      double tolerance) const override {
    return solver_.solve_many(B, X, tolerance);
  }
  std::string name() const override { return "conjugate gradients"; }
  double tolerance() const override { return solver_.options().tolerance; }

 private:
  ConjugateGradient solver_;
};

std::unique_ptr<const LinearSolver> choose(const BlockMatrix& A, double tolerance,
                                           const LinearSolver::Automatic& options) {
  auto iterative = std::make_unique<IterativeSolver>(A, KrylovOptions{tolerance});
  const double blocks = static_cast<double>(A.pattern()->entries()), unknowns = static_cast<double>(A.rows());
  // A factor is not planned where it is out of the question: it has at least the entries of A's lower triangle.
  if (options.memory < 0.5 * 36.0 * blocks) return iterative;
  // Both from zero to the tolerance, under the load of a uniform displacement, which reaches every unknown.
  const Vector load = A * Vector::Ones(A.rows());
  Guess zero;
  const Convergence end = iterative->solve(load, zero);
  constexpr double digits = 6.0;  // that a refinement gains where the step is short
  const double refinements = std::ceil(-std::log10(tolerance) / digits);
  const double iteration = 40.0 * blocks + 9 * 8 * unknowns;  // bytes: A rounded, vectors read and written
  const double product = 76.0 * blocks + 3 * 8 * unknowns;
  FactorPlan plan(A);
  const double bytes = static_cast<double>(plan.bytes());
  if (bytes > options.memory || refinements * (2.0 * bytes + product) > end.iterations * iteration)
    return iterative;
  return std::make_unique<CholeskySolver>(A, std::move(plan), tolerance);
}

}  // namespace

void LinearSolver::Options::validate() const {
  if (!(tolerance > 0.0 && tolerance < 1.0))
    throw InvalidInput("LinearSolver", "tolerance", tolerance, "", "in (0, 1)");
  if (const auto* automatic = std::get_if<Automatic>(&method)) {
    if (!(automatic->memory >= 0.0)) throw InvalidInput("Automatic", "memory", automatic->memory, "bytes", ">= 0");
    return;
  }
  const auto* cholesky = std::get_if<Cholesky>(&method);
  const int most = cholesky ? cholesky->max_iterations : std::get<ConjugateGradients>(method).max_iterations;
  if (most < 1)
    throw InvalidInput(cholesky ? "Cholesky" : "ConjugateGradients", "max_iterations", most, "", ">= 1");
}

KrylovOptions LinearSolver::Options::krylov() const {
  KrylovOptions options{tolerance};
  if (const auto* chosen = std::get_if<ConjugateGradients>(&method))
    options.max_iterations = chosen->max_iterations;
  return options;
}

std::unique_ptr<const LinearSolver> LinearSolver::make(const BlockMatrix& A, const Options& options) {
  options.validate();
  if (const auto* automatic = std::get_if<Automatic>(&options.method))
    return choose(A, options.tolerance, *automatic);
  if (const auto* cholesky = std::get_if<Cholesky>(&options.method))
    return std::make_unique<CholeskySolver>(A, FactorPlan(A), options.tolerance, *cholesky);
  return std::make_unique<IterativeSolver>(A, options.krylov());
}

}  // namespace plica

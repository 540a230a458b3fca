#include "plica/solve/linear_solver.hpp"

#include <cmath>

#include "plica/core/error.hpp"
#include "plica/solve/cholesky_solver.hpp"

namespace plica {
namespace {

class IterativeSolver : public LinearSolver {
 public:
  IterativeSolver(const BlockMatrix& A, const KrylovOptions& options)
      : solver_(A, options),
        bytes_(static_cast<std::ptrdiff_t>(A.values().size() * sizeof(float)) +
               2 * A.rows() * static_cast<std::ptrdiff_t>(sizeof(double))) {}
  Convergence solve(const Vector& b, Guess& guess) const override {
    guess.product = Vector();
    return solver_.solve(b, guess.x);
  }
  std::vector<Convergence> solve_many(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) const override {
    return solver_.solve_many(B, X);
  }
  std::string name() const override { return "conjugate gradients"; }
  std::ptrdiff_t bytes() const override { return bytes_; }
  double tolerance() const override { return solver_.options().tolerance; }

 private:
  ConjugateGradient solver_;
  std::ptrdiff_t bytes_;
};

void check_tolerance(const char* where, double tolerance) {
  if (!(tolerance > 0.0 && tolerance < 1.0)) throw InvalidInput(where, "tolerance", tolerance, "", "in (0, 1)");
}

std::unique_ptr<const LinearSolver> choose(const BlockMatrix& A, const LinearSolver::Automatic& options) {
  auto iterative = std::make_unique<IterativeSolver>(A, KrylovOptions{options.tolerance});
  // Both from zero to the tolerance, under the load of a uniform displacement, which reaches every unknown.
  const Vector load = A * Vector::Ones(A.rows());
  Vector x;
  const Convergence end = ConjugateGradient(A, {options.tolerance}).solve(load, x);
  constexpr double digits = 6.0;  // that a refinement gains where the step is short
  const double refinements = std::ceil(-std::log10(options.tolerance) / digits);
  const double blocks = static_cast<double>(A.pattern()->entries()), unknowns = static_cast<double>(A.rows());
  const double iteration = 40.0 * blocks + 9 * 8 * unknowns;  // bytes: A rounded, vectors read and written
  const double product = 76.0 * blocks + 3 * 8 * unknowns;
  // A factor is not planned where it is out of the question: it has at least the entries of A's lower triangle.
  if (options.memory < 0.5 * 36.0 * blocks) return iterative;
  FactorPlan plan(A);
  const double bytes = static_cast<double>(plan.bytes());
  if (bytes > options.memory || refinements * (2.0 * bytes + product) > end.iterations * iteration)
    return iterative;
  return std::make_unique<CholeskySolver>(A, std::move(plan), LinearSolver::Cholesky{options.tolerance});
}

}  // namespace

void LinearSolver::validate(const Options& options) {
  if (const auto* krylov = std::get_if<KrylovOptions>(&options)) return krylov->validate();
  if (const auto* cholesky = std::get_if<Cholesky>(&options)) {
    check_tolerance("Cholesky", cholesky->tolerance);
    if (cholesky->max_iterations < 1)
      throw InvalidInput("Cholesky", "max_iterations", cholesky->max_iterations, "", ">= 1");
    return;
  }
  const auto& automatic = std::get<Automatic>(options);
  check_tolerance("Automatic", automatic.tolerance);
  if (!(automatic.memory >= 0.0)) throw InvalidInput("Automatic", "memory", automatic.memory, "bytes", ">= 0");
}

std::unique_ptr<const LinearSolver> LinearSolver::make(const BlockMatrix& A, const Options& options) {
  validate(options);
  if (const auto* krylov = std::get_if<KrylovOptions>(&options))
    return std::make_unique<IterativeSolver>(A, *krylov);
  if (const auto* cholesky = std::get_if<Cholesky>(&options))
    return std::make_unique<CholeskySolver>(A, FactorPlan(A), *cholesky);
  return choose(A, std::get<Automatic>(options));
}

}  // namespace plica

#pragma once
#include "plica/solve/linear_solver.hpp"
#include "plica/solve/triangular_factor.hpp"

namespace plica {

/// LinearSolver::Cholesky.
class CholeskySolver : public LinearSolver {
 public:
  CholeskySolver(const BlockMatrix& A, FactorPlan plan, Cholesky options)
      : A_(A), factor_(A, std::move(plan)), options_(options) {}

  Convergence solve(const Vector& b, Guess& guess) const override;
  std::vector<Convergence> solve_many(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) const override;
  std::string name() const override { return "Cholesky"; }
  std::ptrdiff_t bytes() const override { return factor_.plan().bytes(); }
  double tolerance() const override { return options_.tolerance; }
  const TriangularFactor& factor() const { return factor_; }

 private:
  static constexpr double least_gain = 0.1;  // a refinement that leaves more of the residual is not repeated
  void correct(Vector& r, Vector& d, double target, int& iterations) const;

  const BlockMatrix& A_;
  TriangularFactor factor_;
  Cholesky options_;
};

}  // namespace plica

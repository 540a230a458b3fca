#pragma once
#include "plica/solve/linear_solver.hpp"
#include "plica/solve/triangular_factor.hpp"

namespace plica {

/// LinearSolver::Cholesky.
class CholeskySolver : public LinearSolver {
 public:
  CholeskySolver(const BlockMatrix& A, FactorPlan plan, double tolerance, Cholesky options = {})
      : A_(A), factor_(A, std::move(plan)), tolerance_(tolerance), options_(options) {}

  using LinearSolver::solve;
  Convergence solve(const Vector& b, Guess& guess, double tolerance) const override;
  Convergence solve(const Vector& b, Guess& guess, double tolerance, const Product& product) const override;
  std::vector<Convergence> solve_many(const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                                      double tolerance) const override;
  std::string name() const override { return "Cholesky"; }
  double tolerance() const override { return tolerance_; }

 private:
  static constexpr double least_gain = 0.1;  // a refinement that leaves more of the residual is not repeated
  void correct(Vector& r, Vector& d, double target, int& iterations) const;

  const BlockMatrix& A_;
  TriangularFactor factor_;
  double tolerance_;
  Cholesky options_;
};

}  // namespace plica

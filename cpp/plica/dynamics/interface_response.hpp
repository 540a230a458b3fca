#pragma once
#include <Eigen/Cholesky>

#include "plica/solve/linear_solver.hpp"

namespace plica {

/// The displacement (3 m) of the contact's nodes in a step under forces on them, Phi A^-1 Phi^T f, in the place of
/// the inverse of a step matrix that has no other unknowns.
class InterfaceResponse final : public LinearSolver {
 public:
  InterfaceResponse(const Eigen::MatrixXd& shapes, const Eigen::MatrixXd& inverse)
      : root_(inverse.llt().matrixL().transpose() * shapes.transpose()) {}
  Convergence solve(const Vector& b, Guess& guess, double, const Product& product) const override {
    guess.x = root_.transpose() * (root_ * b);
    product(guess.x, guess.product);
    return {1, 0.0, true};
  }
  Convergence solve(const Vector& b, Guess& guess, double) const override {
    guess.x = root_.transpose() * (root_ * b);
    return {1, 0.0, true};
  }
  std::vector<Convergence> solve_many(const Eigen::MatrixXd& B, Eigen::MatrixXd& X, double) const override {
    X = root_.transpose() * (root_ * B);
    return std::vector<Convergence>(static_cast<std::size_t>(B.cols()), {1, 0.0, true});
  }
  std::string name() const override { return "reduced"; }
  double tolerance() const override { return KrylovOptions{}.tolerance; }

 private:
  Eigen::MatrixXd root_;  // (r, 3 m)
};

}  // namespace plica

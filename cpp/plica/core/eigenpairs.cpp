#include "plica/core/eigenpairs.hpp"

#include <Eigen/Eigenvalues>

namespace plica {

Eigenpairs symmetric_eigenpairs(const Eigen::MatrixXd& A) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace plica

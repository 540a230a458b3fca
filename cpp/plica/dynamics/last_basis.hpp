#pragma once
#include <mutex>

#include "plica/core/block_matrix.hpp"

namespace plica {

/// A basis that is orthonormal in the mass: of many scenes, made one after another, each takes that of the one
/// before where its basis (with held unknowns zero) and its mass are the same to the bit. So it is never one of
/// another scene. Threads wait for each other.
class LastBasis {
 public:
  /// vectors (unknowns, any number), zero at held unknowns; throws as mass_orthonormal.
  Eigen::MatrixXd orthonormal(const NodalMatrix& mass, const Eigen::MatrixXd& vectors);

 private:
  std::mutex guard_;
  Pattern pattern_;
  std::vector<double> mass_;
  Eigen::MatrixXd vectors_, found_;
};

/// B with B^T M B = 1, of the span of these vectors but for directions that repeat others to 1e-6. Throws
/// InvalidInput where nothing is left.
Eigen::MatrixXd mass_orthonormal(const NodalMatrix& M, Eigen::MatrixXd B);

/// Y = A X, column by column.
template <typename Matrix>
Eigen::MatrixXd times_columns(const Matrix& A, const Eigen::MatrixXd& X) {
  Eigen::MatrixXd Y(X.rows(), X.cols());
  for (std::ptrdiff_t j = 0; j < X.cols(); ++j) Y.col(j) = A * Vector(X.col(j));
  return Y;
}

}  // namespace plica

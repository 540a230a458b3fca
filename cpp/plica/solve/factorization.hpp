#pragma once
#include <memory>
#include <string>

#include "plica/core/block_matrix.hpp"

namespace plica {

/// Sparse Cholesky factorisation of a symmetric positive definite matrix, for statics, eigenmodes and
/// large steps: Eigen's simplicial LDL^T, or SuiteSparse's supernodal Cholesky in a build with PLICA_GPL.
class Factorization {
 public:
  /// Throws SolveFailed where the matrix is not positive definite ("a body without support?").
  explicit Factorization(const SparseMatrix& A);
  ~Factorization();
  Factorization(Factorization&&) noexcept;
  Factorization& operator=(Factorization&&) noexcept;
  Vector solve(const Vector& b) const;
  static std::string backend();  // "Eigen SimplicialLDLT" or "SuiteSparse CHOLMOD (GPL)"

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace plica

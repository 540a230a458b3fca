#pragma once
#include "plica/core/types.hpp"

namespace plica {

/// A dense matrix for products with one vector at a time, stored as those read it: by panels of rows. In the
/// version for the processor at hand, as the products of core/block_product.hpp.
class PanelMatrix {
 public:
  PanelMatrix() = default;
  explicit PanelMatrix(const Eigen::MatrixXd& A);

  std::ptrdiff_t rows() const { return rows_; }
  std::ptrdiff_t cols() const { return cols_; }
  Vector operator*(const Vector& x) const;

 private:
  std::ptrdiff_t rows_ = 0, cols_ = 0;
  Vector values_;  // panel after panel, each column after column; rows beyond the last are zero
};

/// a . b of vectors of length n, likewise.
double inner_product(const double* a, const double* b, std::ptrdiff_t n);

}  // namespace plica

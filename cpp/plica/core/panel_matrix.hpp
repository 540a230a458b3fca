#pragma once
#include "plica/core/types.hpp"

namespace plica {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A dense matrix for products with one vector at a time, or two, stored as those read it: by panels of rows. In
/// the version for the processor at hand, as the products of core/block_product.hpp.
template <typename Scalar>
class Panels {
 public:
  using Column = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  Panels() = default;
  explicit Panels(const Eigen::MatrixXd& A);
  /// Of these rows of A, one after the other: A is read as it is stored.
  Panels(const RowMajorMatrix& A, const Indices& rows);

  std::ptrdiff_t rows() const { return rows_; }
  std::ptrdiff_t cols() const { return cols_; }
  /// Panel after panel of 16 rows, each column after column; rows beyond the last are zero.
  const Column& values() const { return values_; }
  /// y = A x, in y's memory where it has that size. Trailing zeros of x cost nothing.
  void multiply(const Column& x, Column& y) const;
  Column operator*(const Column& x) const {
    Column y;
    multiply(x, y);
    return y;
  }

 private:
  std::ptrdiff_t rows_ = 0, cols_ = 0;
  Column values_;
};
extern template class Panels<double>;
extern template class Panels<float>;

using PanelMatrix = Panels<double>;
/// In single precision: half the bytes.
using SinglePanelMatrix = Panels<float>;

/// Two vectors side by side, whose product reads the matrix once.
using TwoColumns = Eigen::Matrix<double, Eigen::Dynamic, 2>;
TwoColumns operator*(const PanelMatrix& A, const TwoColumns& x);

/// The same of a matrix whose rows have few columns, neighbours mostly the same: a panel has those that one of its
/// rows has.
class SparsePanels {
 public:
  struct Entry {
    std::int32_t row, column;
    double value;
  };

  SparsePanels() = default;
  /// Entries in any order; those of the same place add up.
  SparsePanels(std::ptrdiff_t rows, const std::vector<Entry>& entries);

  std::ptrdiff_t rows() const { return rows_; }
  Vector operator*(const Vector& x) const;

 private:
  std::ptrdiff_t rows_ = 0;
  std::ptrdiff_t columns_read_ = 0;    // of x
  std::vector<std::size_t> first_;     // (panels + 1) in columns_
  std::vector<std::int32_t> columns_;  // panel after panel
  Vector values_;                      // 16 a column
};

/// a . b of vectors of one length, in a version likewise.
double inner_product(const Eigen::Ref<const Vector>& a, const Vector& b);

}  // namespace plica

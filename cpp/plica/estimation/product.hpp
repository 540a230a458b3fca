#pragma once
#include <cstddef>

#include "plica/core/types.hpp"

namespace plica::estimation {

using DenseMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A dense matrix somewhere in memory, its entry (i, j) at data[i * row_stride + j * column_stride].
template <typename Real>
struct DenseView {
  Real* data;
  std::ptrdiff_t rows, columns, row_stride, column_stride;

  DenseView transposed() const { return {data, columns, rows, column_stride, row_stride}; }
  DenseView block(std::ptrdiff_t row, std::ptrdiff_t column, std::ptrdiff_t height, std::ptrdiff_t width) const {
    return {data + row * row_stride + column * column_stride, height, width, row_stride, column_stride};
  }
  operator DenseView<const Real>() const { return {data, rows, columns, row_stride, column_stride}; }
};
using MatrixView = DenseView<const double>;
using MatrixSpan = DenseView<double>;  // what is written: column_stride = 1

inline MatrixView view(const DenseMatrix& m) { return {m.data(), m.rows(), m.cols(), m.outerStride(), 1}; }
inline MatrixSpan span(DenseMatrix& m) { return {m.data(), m.rows(), m.cols(), m.outerStride(), 1}; }

/// Which entries of a product are wanted: of a symmetric one the upper triangle takes half the work. Entries below
/// the diagonal are then left undefined.
enum class Part { full, upper };
enum class Into { overwrite, add };

/// C = scale A B, or C += scale A B: A (m, k), B (k, n), C (m, n), which must not overlap them. 2 m k n operations
/// in packed tiles, in parallel; every entry takes the same sums for any number of threads.
void multiply(double scale, const MatrixView& a, const MatrixView& b, const MatrixSpan& c, Part part, Into into);

/// Copies the upper triangle of a square matrix to the lower.
void mirror_upper(const MatrixSpan& a);

/// Throws InvalidInput unless the entries of a row lie one behind the other.
void require_rows_together(const char* where, const char* name, const MatrixView& matrix);

}  // namespace plica::estimation

#include "plica/core/panel_matrix.hpp"

#include <algorithm>

#include "plica/core/versions.hpp"

namespace plica {
namespace {

constexpr std::ptrdiff_t width = 16;  // rows of a panel

/// Half of a panel's column: a register where the processor has such wide ones, otherwise the compiler divides it.
#if defined(__GNUC__)
typedef double Half __attribute__((vector_size(4 * width), aligned(8), may_alias));
#else
#error "plica: panel_matrix.cpp needs the vector types of GCC or Clang"
#endif

/// Even and odd columns have sums of their own, so that no sum waits for the one before.
PLICA_INLINE void panel_body(const double* values, const double* x, std::ptrdiff_t columns, double* y) {
  const Half* column = reinterpret_cast<const Half*>(values);
  Half even_top = {}, even_low = {}, odd_top = {}, odd_low = {};
  std::ptrdiff_t j = 0;
  for (; j + 1 < columns; j += 2, column += 4) {
    even_top += column[0] * x[j];
    even_low += column[1] * x[j];
    odd_top += column[2] * x[j + 1];
    odd_low += column[3] * x[j + 1];
  }
  if (j < columns) {
    even_top += column[0] * x[j];
    even_low += column[1] * x[j];
  }
  Half* found = reinterpret_cast<Half*>(y);
  found[0] = even_top + odd_top;
  found[1] = even_low + odd_low;
}

PLICA_INLINE double inner_body(const double* a, const double* b, std::ptrdiff_t n) {
  constexpr std::ptrdiff_t half = width / 2;
  Half even = {}, odd = {};
  std::ptrdiff_t i = 0;
  for (; i + width <= n; i += width) {
    even += *reinterpret_cast<const Half*>(a + i) * *reinterpret_cast<const Half*>(b + i);
    odd += *reinterpret_cast<const Half*>(a + i + half) * *reinterpret_cast<const Half*>(b + i + half);
  }
  even += odd;
  double sum = ((even[0] + even[4]) + (even[1] + even[5])) + ((even[2] + even[6]) + (even[3] + even[7]));
  for (; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

using Panel = void (*)(const double* values, const double* x, std::ptrdiff_t columns, double* y);
void panel_any(const double* values, const double* x, std::ptrdiff_t columns, double* y) {
  panel_body(values, x, columns, y);
}
PLICA_FUSED void panel_fused(const double* values, const double* x, std::ptrdiff_t columns, double* y) {
  panel_body(values, x, columns, y);
}
PLICA_LARGEST void panel_largest(const double* values, const double* x, std::ptrdiff_t columns, double* y) {
  panel_body(values, x, columns, y);
}

using Inner = double (*)(const double* a, const double* b, std::ptrdiff_t n);
double inner_any(const double* a, const double* b, std::ptrdiff_t n) { return inner_body(a, b, n); }
PLICA_FUSED double inner_fused(const double* a, const double* b, std::ptrdiff_t n) { return inner_body(a, b, n); }
PLICA_LARGEST double inner_largest(const double* a, const double* b, std::ptrdiff_t n) {
  return inner_body(a, b, n);
}

}  // namespace

double inner_product(const double* a, const double* b, std::ptrdiff_t n) {
  static const Inner inner = takes_largest() ? inner_largest : takes_fused() ? inner_fused : inner_any;
  return inner(a, b, n);
}

PanelMatrix::PanelMatrix(const Eigen::MatrixXd& A) : rows_(A.rows()), cols_(A.cols()) {
  const std::ptrdiff_t panels = (rows_ + width - 1) / width;
  values_.setZero(panels * width * cols_);
  for (std::ptrdiff_t p = 0; p < panels; ++p)
    for (std::ptrdiff_t j = 0; j < cols_; ++j) {
      const std::ptrdiff_t count = std::min(width, rows_ - p * width);
      values_.segment((p * cols_ + j) * width, count) = A.col(j).segment(p * width, count);
    }
}

Vector PanelMatrix::operator*(const Vector& x) const {
  static const Panel panel = takes_largest() ? panel_largest : takes_fused() ? panel_fused : panel_any;
  Vector y(rows_);
  std::ptrdiff_t columns = cols_;  // trailing zeros of x cost nothing
  while (columns > 0 && x[columns - 1] == 0) --columns;
  const std::ptrdiff_t whole = rows_ / width;
  for (std::ptrdiff_t p = 0; p < whole; ++p)
    panel(values_.data() + p * width * cols_, x.data(), columns, y.data() + p * width);
  if (const std::ptrdiff_t left = rows_ - whole * width; left > 0) {
    double last[width];
    panel(values_.data() + whole * width * cols_, x.data(), columns, last);
    std::copy_n(last, left, y.data() + whole * width);
  }
  return y;
}

}  // namespace plica

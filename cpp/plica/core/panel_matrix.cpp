#include "plica/core/panel_matrix.hpp"

#include <algorithm>

#include "plica/core/registers.hpp"
#include "plica/core/versions.hpp"

namespace plica {
namespace {

constexpr std::ptrdiff_t width = 16;  // rows of a panel

/// Even and odd columns have sums of their own, so that no sum waits for the one before.
template <typename Width>
PLICA_INLINE void panel_body(const double* values, const double* x, std::ptrdiff_t columns, double* y) {
  typedef typename Width::Register Register;
  constexpr int parts = width * sizeof(double) / sizeof(Register);
  const Register* column = reinterpret_cast<const Register*>(values);
  Register even[parts] = {}, odd[parts] = {};
  std::ptrdiff_t j = 0;
  for (; j + 1 < columns; j += 2, column += 2 * parts) {
    for (int k = 0; k < parts; ++k) even[k] += column[k] * x[j];
    for (int k = 0; k < parts; ++k) odd[k] += column[parts + k] * x[j + 1];
  }
  if (j < columns)
    for (int k = 0; k < parts; ++k) even[k] += column[k] * x[j];
  Register* found = reinterpret_cast<Register*>(y);
  for (int k = 0; k < parts; ++k) found[k] = even[k] + odd[k];
}

template <typename Width>
PLICA_INLINE double inner_body(const double* a, const double* b, std::ptrdiff_t n) {
  typedef typename Width::Register Register;
  constexpr int parts = width * sizeof(double) / sizeof(Register), each = width / parts;
  Register sums[parts] = {};
  std::ptrdiff_t i = 0;
  for (; i + width <= n; i += width)
    for (int k = 0; k < parts; ++k)
      sums[k] += *reinterpret_cast<const Register*>(a + i + each * k) *
                 *reinterpret_cast<const Register*>(b + i + each * k);
  double lanes[width];
  for (int k = 0; k < parts; ++k) *reinterpret_cast<Register*>(lanes + each * k) = sums[k];
  for (int half = width / 2; half >= 4; half /= 2)
    for (int k = 0; k < half; ++k) lanes[k] += lanes[k + half];
  double sum = (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
  for (; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

using Panel = void (*)(const double* values, const double* x, std::ptrdiff_t columns, double* y);
void panel_any(const double* values, const double* x, std::ptrdiff_t columns, double* y) {
  panel_body<TwoDoubles>(values, x, columns, y);
}
PLICA_FUSED void panel_fused(const double* values, const double* x, std::ptrdiff_t columns, double* y) {
  panel_body<FourDoubles>(values, x, columns, y);
}
PLICA_LARGEST void panel_largest(const double* values, const double* x, std::ptrdiff_t columns, double* y) {
  panel_body<EightDoubles>(values, x, columns, y);
}

using Inner = double (*)(const double* a, const double* b, std::ptrdiff_t n);
double inner_any(const double* a, const double* b, std::ptrdiff_t n) { return inner_body<TwoDoubles>(a, b, n); }
PLICA_FUSED double inner_fused(const double* a, const double* b, std::ptrdiff_t n) {
  return inner_body<FourDoubles>(a, b, n);
}
PLICA_LARGEST double inner_largest(const double* a, const double* b, std::ptrdiff_t n) {
  return inner_body<EightDoubles>(a, b, n);
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

#include "plica/core/panel_matrix.hpp"

#include <algorithm>
#include <array>
#include <map>

#include "plica/core/registers.hpp"
#include "plica/core/require.hpp"
#include "plica/core/versions.hpp"

namespace plica {
namespace {

constexpr std::ptrdiff_t width = 16;  // rows of a panel

/// Even and odd columns have sums of their own, so that no sum waits for the one before.
template <typename Width, typename Scalar>
PLICA_INLINE void panel_body(const Scalar* values, const Scalar* x, std::ptrdiff_t columns, Scalar* y) {
  typedef typename Width::Register Register;
  constexpr int parts = width * sizeof(Scalar) / sizeof(Register);
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

/// Of entries of x at these places.
template <typename Width>
PLICA_INLINE void sparse_body(const double* values, const std::int32_t* places, std::ptrdiff_t columns,
                              const double* x, double* y) {
  typedef typename Width::Register Register;
  constexpr int parts = width * sizeof(double) / sizeof(Register);
  const Register* column = reinterpret_cast<const Register*>(values);
  Register even[parts] = {}, odd[parts] = {};
  std::ptrdiff_t j = 0;
  for (; j + 1 < columns; j += 2, column += 2 * parts) {
    for (int k = 0; k < parts; ++k) even[k] += column[k] * x[places[j]];
    for (int k = 0; k < parts; ++k) odd[k] += column[parts + k] * x[places[j + 1]];
  }
  if (j < columns)
    for (int k = 0; k < parts; ++k) even[k] += column[k] * x[places[j]];
  Register* found = reinterpret_cast<Register*>(y);
  for (int k = 0; k < parts; ++k) found[k] = even[k] + odd[k];
}

/// Of two vectors x (columns, 2), to y (width, 2).
template <typename Width>
PLICA_INLINE void two_body(const double* values, const double* x, std::ptrdiff_t columns, double* y) {
  typedef typename Width::Register Register;
  constexpr int parts = width * sizeof(double) / sizeof(Register);
  const Register* column = reinterpret_cast<const Register*>(values);
  Register sums[2][parts] = {};
  for (std::ptrdiff_t j = 0; j < columns; ++j, column += parts)
    for (int v = 0; v < 2; ++v)
      for (int k = 0; k < parts; ++k) sums[v][k] += column[k] * x[v * columns + j];
  for (int v = 0; v < 2; ++v)
    for (int k = 0; k < parts; ++k) reinterpret_cast<Register*>(y + width * v)[k] = sums[v][k];
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

template <typename Scalar>
struct Registers;
template <>
struct Registers<double> {
  using Any = TwoDoubles;
  using Fused = FourDoubles;
  using Largest = EightDoubles;
};
template <>
struct Registers<float> {
  using Any = FourSingles;
  using Fused = EightSingles;
  using Largest = SixteenSingles;
};

template <typename Scalar>
using Panel = void (*)(const Scalar* values, const Scalar* x, std::ptrdiff_t columns, Scalar* y);
template <typename Scalar>
void panel_any(const Scalar* values, const Scalar* x, std::ptrdiff_t columns, Scalar* y) {
  panel_body<typename Registers<Scalar>::Any>(values, x, columns, y);
}
template <typename Scalar>
PLICA_FUSED void panel_fused(const Scalar* values, const Scalar* x, std::ptrdiff_t columns, Scalar* y) {
  panel_body<typename Registers<Scalar>::Fused>(values, x, columns, y);
}
template <typename Scalar>
PLICA_LARGEST void panel_largest(const Scalar* values, const Scalar* x, std::ptrdiff_t columns, Scalar* y) {
  panel_body<typename Registers<Scalar>::Largest>(values, x, columns, y);
}
using SparsePanel = void (*)(const double* values, const std::int32_t* places, std::ptrdiff_t columns,
                             const double* x, double* y);
void sparse_any(const double* values, const std::int32_t* places, std::ptrdiff_t columns, const double* x,
                double* y) {
  sparse_body<TwoDoubles>(values, places, columns, x, y);
}
PLICA_FUSED void sparse_fused(const double* values, const std::int32_t* places, std::ptrdiff_t columns,
                              const double* x, double* y) {
  sparse_body<FourDoubles>(values, places, columns, x, y);
}
PLICA_LARGEST void sparse_largest(const double* values, const std::int32_t* places, std::ptrdiff_t columns,
                                  const double* x, double* y) {
  sparse_body<EightDoubles>(values, places, columns, x, y);
}

void two_any(const double* values, const double* x, std::ptrdiff_t columns, double* y) {
  two_body<TwoDoubles>(values, x, columns, y);
}
PLICA_FUSED void two_fused(const double* values, const double* x, std::ptrdiff_t columns, double* y) {
  two_body<FourDoubles>(values, x, columns, y);
}
PLICA_LARGEST void two_largest(const double* values, const double* x, std::ptrdiff_t columns, double* y) {
  two_body<EightDoubles>(values, x, columns, y);
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

double inner_product(const Eigen::Ref<const Vector>& a, const Vector& b) {
  require_size("inner_product", "b", b.size(), a.size());
  static const Inner inner = takes_largest() ? inner_largest : takes_fused() ? inner_fused : inner_any;
  return inner(a.data(), b.data(), a.size());
}

template <typename Scalar>
Panels<Scalar>::Panels(const Eigen::MatrixXd& A) : rows_(A.rows()), cols_(A.cols()) {
  const std::ptrdiff_t panels = (rows_ + width - 1) / width;
  values_.setZero(panels * width * cols_);
  for (std::ptrdiff_t p = 0; p < panels; ++p)
    for (std::ptrdiff_t j = 0; j < cols_; ++j) {
      const std::ptrdiff_t count = std::min(width, rows_ - p * width);
      values_.segment((p * cols_ + j) * width, count) = A.col(j).segment(p * width, count).template cast<Scalar>();
    }
}

template <typename Scalar>
Panels<Scalar>::Panels(const RowMajorMatrix& A, const Indices& rows) : rows_(rows.size()), cols_(A.cols()) {
  require_indices("Panels", "row", rows, A.rows());
  const std::ptrdiff_t panels = (rows_ + width - 1) / width;
  values_.resize(panels * width * cols_);
  const double* row[width];
  for (std::ptrdiff_t p = 0; p < panels; ++p) {
    const std::ptrdiff_t count = std::min(width, rows_ - p * width);
    for (std::ptrdiff_t k = 0; k < count; ++k) row[k] = A.row(rows[p * width + k]).data();
    Scalar* panel = values_.data() + p * width * cols_;
    for (std::ptrdiff_t j = 0; j < cols_; ++j, panel += width) {
      for (std::ptrdiff_t k = 0; k < count; ++k) panel[k] = static_cast<Scalar>(row[k][j]);
      std::fill(panel + count, panel + width, Scalar(0));
    }
  }
}

template <typename Scalar>
void Panels<Scalar>::multiply(const Column& x, Column& y) const {
  static const Panel<Scalar> panel = takes_largest() ? panel_largest<Scalar>
                                     : takes_fused() ? panel_fused<Scalar>
                                                     : panel_any<Scalar>;
  require_size("Panels", "x", x.size(), cols_);
  y.resize(rows_);
  std::ptrdiff_t columns = cols_;
  while (columns > 0 && x[columns - 1] == 0) --columns;
  const std::ptrdiff_t whole = rows_ / width;
  for (std::ptrdiff_t p = 0; p < whole; ++p)
    panel(values_.data() + p * width * cols_, x.data(), columns, y.data() + p * width);
  if (const std::ptrdiff_t left = rows_ - whole * width; left > 0) {
    Scalar last[width];
    panel(values_.data() + whole * width * cols_, x.data(), columns, last);
    std::copy_n(last, left, y.data() + whole * width);
  }
}

template class Panels<double>;
template class Panels<float>;

TwoColumns operator*(const PanelMatrix& A, const TwoColumns& x) {
  static const Panel<double> panel = takes_largest() ? two_largest : takes_fused() ? two_fused : two_any;
  require_size("Panels", "rows of x", x.rows(), A.cols());
  TwoColumns y(A.rows(), 2);
  double found[2 * width];
  for (std::ptrdiff_t row = 0; row < A.rows(); row += width) {
    panel(A.values().data() + row * A.cols(), x.data(), A.cols(), found);
    const std::ptrdiff_t count = std::min(width, A.rows() - row);
    for (int v = 0; v < 2; ++v) std::copy_n(found + width * v, count, y.col(v).data() + row);
  }
  return y;
}

SparsePanels::SparsePanels(std::ptrdiff_t rows, const std::vector<Entry>& entries) : rows_(rows) {
  require_at_least("SparsePanels", "the rows", rows, 0);
  for (const auto& [row, column, value] : entries) {
    require_index("SparsePanels", "row of an entry", row, rows);
    require_at_least("SparsePanels", "the columns of an entry", column, 0);
    columns_read_ = std::max<std::ptrdiff_t>(columns_read_, column + std::ptrdiff_t{1});
  }
  std::map<std::pair<std::ptrdiff_t, std::int32_t>, std::array<double, width>> sums;  // of panel and column
  for (const auto& [row, column, value] : entries)
    sums.try_emplace({row / width, column}).first->second[static_cast<std::size_t>(row % width)] += value;
  values_.resize(width * static_cast<std::ptrdiff_t>(sums.size()));
  for (const auto& [key, values] : sums) {
    while (static_cast<std::ptrdiff_t>(first_.size()) <= key.first) first_.push_back(columns_.size());
    std::copy(values.begin(), values.end(), values_.data() + width * static_cast<std::ptrdiff_t>(columns_.size()));
    columns_.push_back(key.second);
  }
  while (static_cast<std::ptrdiff_t>(first_.size()) <= (rows + width - 1) / width)
    first_.push_back(columns_.size());
}

Vector SparsePanels::operator*(const Vector& x) const {
  static const SparsePanel panel = takes_largest() ? sparse_largest : takes_fused() ? sparse_fused : sparse_any;
  require_at_least("SparsePanels", "x", x.size(), columns_read_);
  Vector y(rows_);
  double found[width];
  for (std::ptrdiff_t row = 0; row < rows_; row += width) {
    const std::size_t begin = first_[static_cast<std::size_t>(row / width)],
                      end = first_[static_cast<std::size_t>(row / width) + 1];
    panel(values_.data() + width * static_cast<std::ptrdiff_t>(begin), columns_.data() + begin,
          static_cast<std::ptrdiff_t>(end - begin), x.data(), found);
    std::copy_n(found, std::min(width, rows_ - row), y.data() + row);
  }
  return y;
}

}  // namespace plica

#include "plica/solve/front.hpp"

#include <algorithm>
#include <cmath>

#include "plica/solve/panel_kernels.hpp"

namespace plica {
namespace {

constexpr std::ptrdiff_t tall = 8, wide = 4;  // of the kernel's block

/// Rows [begin, n) of the columns [from, to) in strips of `height` rows, each column after column, ends filled up
/// with zeros.
void pack(Front& front, std::ptrdiff_t begin, std::ptrdiff_t from, std::ptrdiff_t to, std::ptrdiff_t height,
          std::vector<double>& packed) {
  const std::ptrdiff_t count = to - from, rows = front.size - begin;
  packed.assign(static_cast<std::size_t>((rows + height - 1) / height * height * count), 0.0);
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    const double* column = front.column(from + k) + begin;
    for (std::ptrdiff_t i = 0; i < rows; ++i)
      packed[i / height * height * count + k * height + i % height] = column[i];
  }
}

/// Subtracts the product of the columns [from, to) with their transpose from the columns that follow.
void update(Front& front, std::ptrdiff_t from, std::ptrdiff_t to) {
  const std::ptrdiff_t n = front.size, count = to - from;
  std::vector<double> a, b;
  pack(front, to, from, to, tall, a);
  pack(front, to, from, to, wide, b);
  for (std::ptrdiff_t j = to; j < n; j += wide) {
    const std::ptrdiff_t columns = std::min(wide, n - j);
    for (std::ptrdiff_t i = to + (j - to) / tall * tall; i < n; i += tall) {
      const std::ptrdiff_t rows = std::min(tall, n - i);
      double c[tall * wide];
      panel_kernels().strip_product(a.data() + (i - to) * count, b.data() + (j - to) * count, count, c);
      for (std::ptrdiff_t q = 0; q < columns; ++q) {
        double* out = front.column(j + q) + i;
        for (std::ptrdiff_t p = 0; p < rows; ++p) out[p] -= c[tall * q + p];
      }
    }
  }
}

}  // namespace

std::ptrdiff_t Front::eliminate(std::ptrdiff_t pivots, double least) {
  constexpr std::ptrdiff_t block = 48;
  for (std::ptrdiff_t from = 0; from < pivots; from += block) {
    const std::ptrdiff_t to = std::min(pivots, from + block);
    for (std::ptrdiff_t j = from; j < to; ++j) {
      double* column_j = column(j);
      std::ptrdiff_t k = from;
      for (; k + 4 <= j; k += 4) {
        const double* x[] = {column(k) + j, column(k + 1) + j, column(k + 2) + j, column(k + 3) + j};
        const double a[] = {*x[0], *x[1], *x[2], *x[3]};
        panel_kernels().subtract_columns(x, a, column_j + j, size - j);
      }
      for (; k < j; ++k) {
        const double a = at(j, k);
        for (std::ptrdiff_t i = j; i < size; ++i) column_j[i] -= a * at(i, k);
      }
      if (!(column_j[j] > least && std::isfinite(column_j[j]))) return j;
      const double diagonal = std::sqrt(column_j[j]);
      column_j[j] = diagonal;
      for (std::ptrdiff_t i = j + 1; i < size; ++i) column_j[i] /= diagonal;
    }
    if (to < size) update(*this, from, to);
  }
  return -1;
}

}  // namespace plica

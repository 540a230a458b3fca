#include "plica/estimation/covariance.hpp"

#include <algorithm>

#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"
#include "plica/estimation/product_kernels.hpp"

namespace plica::estimation {
namespace {

constexpr std::ptrdiff_t solved_at_once = 48;    // rows of a triangle that stay in cache beside a strip of X
constexpr std::ptrdiff_t factored_at_once = 32;  // rows of a triangle that are factored row by row

/// The larger half, whole blocks of the smallest size.
std::ptrdiff_t split(std::ptrdiff_t n, std::ptrdiff_t block) { return (n / 2 + block - 1) / block * block; }

using Solve = void (*)(const double* r, std::ptrdiff_t stride, std::ptrdiff_t n, double* x);

/// A triangle that is small: strips of X are copied to where they lie together, solved, copied back.
void solve_strips(Solve solve, const MatrixView& r, const MatrixSpan& x) {
  const std::ptrdiff_t width = product_kernels().strip, n = x.rows;
  for_chunks(x.columns, width, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    alignas(64) double strip[solved_at_once * 64];
    const std::ptrdiff_t count = end - begin;
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      const double* from = x.data + i * x.row_stride + begin;
      std::copy(from, from + count, strip + i * width);
      std::fill(strip + i * width + count, strip + (i + 1) * width, 0.0);
    }
    solve(r.data, r.row_stride, n, strip);
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      std::copy(strip + i * width, strip + i * width + count, x.data + i * x.row_stride + begin);
    }
  });
}

/// As cholesky(), the lower triangle left as it is.
std::ptrdiff_t factor(const MatrixSpan& a) {
  const std::ptrdiff_t n = a.rows;
  if (n <= factored_at_once) return product_kernels().cholesky(a.data, a.row_stride, n);
  const std::ptrdiff_t half = split(n, 16), rest = n - half;
  const std::ptrdiff_t stopped = factor(a.block(0, 0, half, half));
  if (stopped < half) return stopped;
  const MatrixSpan right = a.block(0, half, half, rest), below = a.block(half, half, rest, rest);
  solve_lower(a.block(0, 0, half, half), right);
  multiply(-1.0, MatrixView(right).transposed(), right, below, Part::upper, Into::add);
  return half + factor(below);
}

/// What the kernels of a triangular solve read and write.
void require_triangle(const char* where, const MatrixView& r, const MatrixSpan& x) {
  require_size(where, "columns of R", r.columns, r.rows);
  require_rows_together(where, "R", r);
  require_size(where, "rows of X", x.rows, r.rows);
  require_rows_together(where, "X", x);
}

}  // namespace

void congruence(const MatrixView& g, const MatrixView& p, const MatrixSpan& c, Into into) {
  require_size("congruence", "rows of P", p.rows, g.columns);
  require_size("congruence", "columns of P", p.columns, g.columns);
  require_size("congruence", "rows of C", c.rows, g.rows);
  require_size("congruence", "columns of C", c.columns, g.rows);
  static thread_local DenseMatrix kept;
  if (kept.rows() != g.rows || kept.cols() != g.columns) kept.resize(g.rows, g.columns);
  multiply(1.0, g, p, span(kept), Part::full, Into::overwrite);
  symmetric_product(view(kept), g.transposed(), c, into);
}

void symmetric_product(const MatrixView& a, const MatrixView& b, const MatrixSpan& c, Into into) {
  require_size("symmetric_product", "columns of C", c.columns, c.rows);
  multiply(1.0, a, b, c, Part::upper, into);
  mirror_upper(c);
}

void gram_update(double scale, const MatrixView& w, const MatrixSpan& p) {
  multiply(scale, w.transposed(), w, p, Part::upper, Into::add);
  mirror_upper(p);
}

std::ptrdiff_t cholesky(const MatrixSpan& a) {
  require_size("cholesky", "columns of A", a.columns, a.rows);
  require_rows_together("cholesky", "A", a);
  const std::ptrdiff_t done = factor(a);
  for (std::ptrdiff_t i = 1; i < a.rows; ++i) std::fill_n(a.data + i * a.row_stride, i, 0.0);
  return done;
}

void solve_lower(const MatrixView& r, const MatrixSpan& x) {
  require_triangle("solve_lower", r, x);
  const std::ptrdiff_t n = r.rows;
  if (n <= solved_at_once) return solve_strips(product_kernels().forward, r, x);
  const std::ptrdiff_t half = split(n, 16), rest = n - half;
  const MatrixSpan top = x.block(0, 0, half, x.columns), bottom = x.block(half, 0, rest, x.columns);
  solve_lower(r.block(0, 0, half, half), top);
  multiply(-1.0, r.block(0, half, half, rest).transposed(), top, bottom, Part::full, Into::add);
  solve_lower(r.block(half, half, rest, rest), bottom);
}

void solve_upper(const MatrixView& r, const MatrixSpan& x) {
  require_triangle("solve_upper", r, x);
  const std::ptrdiff_t n = r.rows;
  if (n <= solved_at_once) return solve_strips(product_kernels().backward, r, x);
  const std::ptrdiff_t half = split(n, 16), rest = n - half;
  const MatrixSpan top = x.block(0, 0, half, x.columns), bottom = x.block(half, 0, rest, x.columns);
  solve_upper(r.block(half, half, rest, rest), bottom);
  multiply(-1.0, r.block(0, half, half, rest), bottom, top, Part::full, Into::add);
  solve_upper(r.block(0, 0, half, half), top);
}

}  // namespace plica::estimation

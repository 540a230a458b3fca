#include "plica/solve/krylov.hpp"

#include <algorithm>
#include <cmath>

#include "plica/core/block_product.hpp"
#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"

namespace plica {
namespace {

constexpr std::ptrdiff_t chunk_rows = BlockMatrix::chunk_rows;

/// Sums of one chunk of rows.
struct Sums {
  double first = 0.0, second = 0.0;
};

/// sum a_i b_i in eight running sums.
double dot(const double* a, const double* b, std::ptrdiff_t n) {
  double s[8] = {};
  std::ptrdiff_t i = 0;
  for (; i + 8 <= n; i += 8) {
    for (int k = 0; k < 8; ++k) s[k] += a[i + k] * b[i + k];
  }
  for (int k = 0; i < n; ++i, ++k) s[k] += a[i] * b[i];
  return ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7]));
}

/// y += a x
void add_scaled(double a, const double* x, double* y, std::ptrdiff_t n) {
  for (std::ptrdiff_t i = 0; i < n; ++i) y[i] += a * x[i];
}

/// y = x + a y
void scale_and_add(double a, const double* x, double* y, std::ptrdiff_t n) {
  for (std::ptrdiff_t i = 0; i < n; ++i) y[i] = x[i] + a * y[i];
}

/// z = (diagonal blocks)^-1 r in the node rows [begin, end).
void apply_inverse(const double* inverse, const double* r, double* z, std::ptrdiff_t begin, std::ptrdiff_t end) {
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    const double* m = inverse + 6 * i;
    const double r0 = r[3 * i], r1 = r[3 * i + 1], r2 = r[3 * i + 2];
    z[3 * i] = m[0] * r0 + m[1] * r1 + m[2] * r2;
    z[3 * i + 1] = m[1] * r0 + m[3] * r1 + m[4] * r2;
    z[3 * i + 2] = m[2] * r0 + m[4] * r1 + m[5] * r2;
  }
}

/// Runs work(begin, end) -> Sums over all chunks of rows; the total is taken in chunk order.
template <typename Work>
Sums sum_over_rows(std::ptrdiff_t rows, std::vector<Sums>& partial, const Work& work) {
  for_chunks(rows, chunk_rows, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t chunk) {
    partial[static_cast<std::size_t>(chunk)] = work(begin, end);
  });
  Sums total;
  for (const Sums& part : partial) {
    total.first += part.first;
    total.second += part.second;
  }
  return total;
}

void check_size(const char* name, std::ptrdiff_t size, std::ptrdiff_t rows) {
  if (size != rows) {
    throw InvalidInput("ConjugateGradient", name, static_cast<double>(size), "",
                       "the number of rows, " + number_text(static_cast<double>(rows)));
  }
}

void require_rows_of(const BlockMatrix& A, std::ptrdiff_t begin, std::ptrdiff_t end, const Vector& from,
                     const Vector& to) {
  require_range("ConjugateGradient", begin, end, A.pattern()->rows());
  require_size("ConjugateGradient", "what is read", from.size(), A.rows());
  require_size("ConjugateGradient", "what is written", to.size(), A.rows());
}

void check_finite(const Convergence& state, double value, const char* name) {
  if (std::isfinite(value)) return;
  throw SolveFailed(std::string("ConjugateGradient: ") + name + " = " + number_text(value) + " in iteration " +
                    number_text(state.iterations) +
                    "; must be finite. Are the matrix, the right-hand side and the start finite?");
}

}  // namespace

void KrylovOptions::validate() const {
  if (!(tolerance > 0.0 && tolerance < 1.0)) {
    throw InvalidInput("KrylovOptions", "tolerance", tolerance, "", "in (0, 1)");
  }
  if (max_iterations < 1) throw InvalidInput("KrylovOptions", "max_iterations", max_iterations, "", ">= 1");
}

ConjugateGradient::ConjugateGradient(const BlockMatrix& A, KrylovOptions options) : A_(&A), options_(options) {
  options_.validate();
  const NodePattern& p = *A.pattern();
  inverse_.resize(static_cast<std::size_t>(6 * p.rows()));
  for (std::int32_t i = 0; i < p.rows(); ++i) {
    const double* a = A.block(p.find(i, i));
    const double c00 = a[4] * a[8] - a[5] * a[5], c01 = a[2] * a[5] - a[1] * a[8], c02 = a[1] * a[5] - a[2] * a[4];
    const double det = a[0] * c00 + a[1] * c01 + a[2] * c02;
    if (!(a[0] > 0.0 && a[0] * a[4] - a[1] * a[1] > 0.0 && det > 0.0 && std::isfinite(det))) {
      throw SolveFailed("ConjugateGradient: matrix is not positive definite: diagonal block of node " +
                        number_text(i) + " has determinant " + number_text(det) +
                        ". Is a node without element, or an element inverted?");
    }
    double* m = inverse_.data() + 6 * static_cast<std::ptrdiff_t>(i);
    m[0] = c00 / det;
    m[1] = c01 / det;
    m[2] = c02 / det;
    m[3] = (a[0] * a[8] - a[2] * a[2]) / det;
    m[4] = (a[1] * a[2] - a[0] * a[5]) / det;
    m[5] = (a[0] * a[4] - a[1] * a[1]) / det;
  }
}

void ConjugateGradient::precondition(const Vector& r, Vector& z) const {
  check_size("r.size()", r.size(), A_->rows());
  z.resize(r.size());
  for_chunks(r.size() / 3, chunk_rows, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    precondition_rows(begin, end, r, z);
  });
}

void ConjugateGradient::precondition_rows(std::ptrdiff_t begin, std::ptrdiff_t end, const Vector& r,
                                          Vector& z) const {
  require_rows_of(*A_, begin, end, r, z);
  apply_inverse(inverse_.data(), r.data(), z.data(), begin, end);
}

void ConjugateGradient::make_single() const {
  std::call_once(single_made_, [this] { single_.assign(A_->values().begin(), A_->values().end()); });
}

void ConjugateGradient::multiply_rounded_rows(std::ptrdiff_t begin, std::ptrdiff_t end, const Vector& p,
                                              Vector& q) const {
  require_rows_of(*A_, begin, end, p, q);
  make_single();
  const NodePattern& pattern = *A_->pattern();
  row_products().blocks_single(pattern.row_start.data(), pattern.column.data(), single_.data(), p.data(), q.data(),
                               begin, end);
}

Convergence ConjugateGradient::solve(const Vector& b, Vector& x, double tolerance) const {
  constexpr double finest = 1e-6;  // a correction is not asked for more than the rounded matrix can give
  const std::ptrdiff_t unknowns = A_->rows(), nodes = unknowns / 3;
  check_size("b.size()", b.size(), unknowns);
  if (x.size() == 0) x = Vector::Zero(unknowns);
  check_size("x.size()", x.size(), unknowns);
  Vector r(unknowns), d(unknowns);
  std::vector<Sums> partial(static_cast<std::size_t>((nodes + chunk_rows - 1) / chunk_rows));

  Convergence state;
  // r = b - A x; returns |r| and |b|, squared
  const auto residual = [&](bool zero_start) {
    return sum_over_rows(nodes, partial, [&](std::ptrdiff_t begin, std::ptrdiff_t end) -> Sums {
      const std::ptrdiff_t at = 3 * begin, count = 3 * (end - begin);
      if (zero_start) {
        for (std::ptrdiff_t i = at; i < at + count; ++i) r[i] = b[i];
      } else {
        A_->multiply_rows(begin, end, x, r);
        for (std::ptrdiff_t i = at; i < at + count; ++i) r[i] = b[i] - r[i];
      }
      return {dot(r.data() + at, r.data() + at, count), dot(b.data() + at, b.data() + at, count)};
    });
  };
  const Sums start = residual((x.array() == 0.0).all());
  const double b_norm = std::sqrt(start.second);
  if (b_norm == 0.0) {
    x.setZero();
    state.converged = true;
    return state;
  }
  state.residual = std::sqrt(start.first) / b_norm;
  check_finite(state, b_norm, "|b|");
  check_finite(state, state.residual, "|b - A x| / |b|");
  const auto rounded = [&](std::ptrdiff_t begin, std::ptrdiff_t end, const Vector& p, Vector& q) {
    multiply_rounded_rows(begin, end, p, q);
  };
  const auto exact = [&](std::ptrdiff_t begin, std::ptrdiff_t end, const Vector& p, Vector& q) {
    A_->multiply_rows(begin, end, p, q);
  };
  bool single = true;
  while (state.residual > tolerance && state.iterations < options_.max_iterations) {
    const double before = state.residual, target = 0.5 * tolerance / before;
    const double curvature =
        single ? correct(rounded, r, d, std::max(finest, target), state) : correct(exact, r, d, target, state);
    if (!single) {
      check_finite(state, curvature, "p^T A p");
      if (curvature <= 0.0)
        throw SolveFailed("ConjugateGradient: matrix is not positive definite: p^T A p = " +
                          number_text(curvature) + " in iteration " + number_text(state.iterations) +
                          ". Is the body held, and is every element the right way round?");
    }
    x += d;
    state.residual = std::sqrt(residual(false).first) / b_norm;
    const bool stagnates = !(curvature > 0.0) || !(state.residual <= 0.5 * before);
    if (single && !(state.residual <= before)) {  // the rounded matrix led away
      x -= d;
      state.residual = std::sqrt(residual(false).first) / b_norm;
    }
    check_finite(state, state.residual, "|b - A x| / |b|");
    if (stagnates && !single) break;  // round-off is reached
    single = single && !stagnates;
  }
  state.converged = state.residual <= tolerance;
  return state;
}

template <typename Product>
double ConjugateGradient::correct(const Product& product, Vector& r, Vector& d, double target,
                                  Convergence& state) const {
  const std::ptrdiff_t unknowns = A_->rows(), nodes = unknowns / 3;
  Vector z(unknowns), p(unknowns), q(unknowns);
  std::vector<Sums> partial(static_cast<std::size_t>((nodes + chunk_rows - 1) / chunk_rows));
  const Sums start = sum_over_rows(nodes, partial, [&](std::ptrdiff_t begin, std::ptrdiff_t end) -> Sums {
    const std::ptrdiff_t at = 3 * begin, count = 3 * (end - begin);
    precondition_rows(begin, end, r, z);
    for (std::ptrdiff_t i = at; i < at + count; ++i) p[i] = z[i], d[i] = 0.0;
    return {dot(r.data() + at, z.data() + at, count), dot(r.data() + at, r.data() + at, count)};
  });
  double rz = start.first, pq = 1.0;
  const double enough = target * target * start.second;
  for (double rr = start.second; rr > enough && state.iterations < options_.max_iterations;) {
    ++state.iterations;
    pq = sum_over_rows(nodes, partial, [&](std::ptrdiff_t begin, std::ptrdiff_t end) -> Sums {
           product(begin, end, p, q);
           return {dot(p.data() + 3 * begin, q.data() + 3 * begin, 3 * (end - begin)), 0.0};
         }).first;
    if (!(pq > 0.0 && std::isfinite(pq))) break;
    const double alpha = rz / pq;
    const Sums sums = sum_over_rows(nodes, partial, [&](std::ptrdiff_t begin, std::ptrdiff_t end) -> Sums {
      const std::ptrdiff_t at = 3 * begin, count = 3 * (end - begin);
      add_scaled(-alpha, q.data() + at, r.data() + at, count);
      precondition_rows(begin, end, r, z);
      return {dot(r.data() + at, z.data() + at, count), dot(r.data() + at, r.data() + at, count)};
    });
    const double beta = sums.first / rz;
    rz = sums.first;
    rr = sums.second;
    check_finite(state, rr, "|b - A x| / |b|");
    for_chunks(nodes, chunk_rows, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
      const std::ptrdiff_t at = 3 * begin, count = 3 * (end - begin);
      add_scaled(alpha, p.data() + at, d.data() + at, count);
      scale_and_add(beta, z.data() + at, p.data() + at, count);
    });
  }
  return pq;
}

}  // namespace plica

// Conjugate gradients for several right-hand sides, `pack` of them interleaved: unknown u of vector v at pack u +
// v.
#include <algorithm>
#include <array>
#include <cmath>

#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "plica/solve/krylov.hpp"

namespace plica {
namespace {

constexpr int pack = BlockMatrix::pack;
constexpr std::ptrdiff_t chunk_rows = BlockMatrix::chunk_rows;
using Lanes = std::array<double, pack>;  // one number for each vector
struct Sums {
  Lanes first{}, second{};
};

void add_dots(const double* a, const double* b, std::ptrdiff_t unknowns, Lanes& sum) {
  double s[pack] = {};  // a local array: the compiler keeps it in registers
  for (std::ptrdiff_t i = 0; i < unknowns; ++i) {
    for (int v = 0; v < pack; ++v) s[v] += a[pack * i + v] * b[pack * i + v];
  }
  for (int v = 0; v < pack; ++v) sum[v] += s[v];
}

/// y += a x, vector by vector.
void add_scaled(const Lanes& a, const double* x, double* y, std::ptrdiff_t unknowns) {
  const Lanes factor = a;
  for (std::ptrdiff_t i = 0; i < unknowns; ++i) {
    for (int v = 0; v < pack; ++v) y[pack * i + v] += factor[v] * x[pack * i + v];
  }
}

/// y = x + a y, vector by vector.
void scale_and_add(const Lanes& a, const double* x, double* y, std::ptrdiff_t unknowns) {
  const Lanes factor = a;
  for (std::ptrdiff_t i = 0; i < unknowns; ++i) {
    for (int v = 0; v < pack; ++v) y[pack * i + v] = x[pack * i + v] + factor[v] * y[pack * i + v];
  }
}

void apply_inverse(const double* inverse, const double* r, double* z, std::ptrdiff_t begin, std::ptrdiff_t end) {
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    const double* m = inverse + 6 * i;
    const double *r0 = r + 3 * pack * i, *r1 = r0 + pack, *r2 = r1 + pack;
    double *z0 = z + 3 * pack * i, *z1 = z0 + pack, *z2 = z1 + pack;
    for (int v = 0; v < pack; ++v) {
      const double a = r0[v], b = r1[v], c = r2[v];
      z0[v] = m[0] * a + m[1] * b + m[2] * c;
      z1[v] = m[1] * a + m[3] * b + m[4] * c;
      z2[v] = m[2] * a + m[4] * b + m[5] * c;
    }
  }
}

template <typename Work>
Sums sum_over_rows(std::ptrdiff_t rows, std::vector<Sums>& partial, const Work& work) {
  for_chunks(rows, chunk_rows, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t chunk) {
    Sums sums;
    work(begin, end, sums);
    partial[static_cast<std::size_t>(chunk)] = sums;
  });
  Sums total;
  for (const Sums& part : partial) {
    for (int v = 0; v < pack; ++v) {
      total.first[v] += part.first[v];
      total.second[v] += part.second[v];
    }
  }
  return total;
}

[[noreturn]] void fail(const std::string& what, std::ptrdiff_t column, int iteration) {
  throw SolveFailed("ConjugateGradient: " + what + " in iteration " + number_text(iteration) +
                    " of right-hand side " + number_text(static_cast<double>(column)) +
                    ". Is the body held, is every element the right way round, is every number finite?");
}

}  // namespace

std::vector<Convergence> ConjugateGradient::solve_many(const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                                                       double tolerance) const {
  const std::ptrdiff_t unknowns = A_->rows(), nodes = unknowns / 3;
  if (B.rows() != unknowns) {
    throw InvalidInput("ConjugateGradient", "B.rows()", static_cast<double>(B.rows()), "",
                       "the number of rows, " + number_text(static_cast<double>(unknowns)));
  }
  std::vector<Convergence> states(static_cast<std::size_t>(B.cols()));
  Eigen::MatrixXd solution(unknowns, B.cols());
  const auto length = static_cast<std::size_t>(pack * unknowns);
  std::vector<double> x(length), r(length), z(length), p(length), q(length);
  std::vector<Sums> partial(static_cast<std::size_t>((nodes + chunk_rows - 1) / chunk_rows));

  for (std::ptrdiff_t first = 0; first < B.cols(); first += pack) {
    const int width = static_cast<int>(std::min<std::ptrdiff_t>(pack, B.cols() - first));
    // Lanes beyond the last column, and those that have converged, go along with steps of length zero.
    const Sums start = sum_over_rows(nodes, partial, [&](std::ptrdiff_t begin, std::ptrdiff_t end, Sums& sums) {
      for (std::ptrdiff_t i = 3 * begin; i < 3 * end; ++i) {
        for (int v = 0; v < pack; ++v) {
          x[pack * i + v] = 0.0;
          r[pack * i + v] = v < width ? B(i, first + v) : 0.0;
        }
      }
      apply_inverse(inverse_.data(), r.data(), z.data(), begin, end);
      const std::ptrdiff_t at = 3 * pack * begin, count = 3 * (end - begin);
      std::copy_n(z.data() + at, pack * count, p.data() + at);
      add_dots(r.data() + at, z.data() + at, count, sums.first);
      add_dots(r.data() + at, r.data() + at, count, sums.second);
    });
    Lanes rz = start.first, b_norm{};
    std::array<bool, pack> running{};
    for (int v = 0; v < width; ++v) {
      Convergence& state = states[static_cast<std::size_t>(first + v)];
      b_norm[v] = std::sqrt(start.second[v]);
      if (!std::isfinite(b_norm[v])) fail("|b| = " + number_text(b_norm[v]), first + v, 0);
      running[v] = b_norm[v] > 0.0;
      state.converged = !running[v];
      state.residual = running[v] ? 1.0 : 0.0;
    }

    for (int iteration = 1; iteration <= options_.max_iterations; ++iteration) {
      if (std::none_of(running.begin(), running.end(), [](bool b) { return b; })) break;
      const Sums product =
          sum_over_rows(nodes, partial, [&](std::ptrdiff_t begin, std::ptrdiff_t end, Sums& sums) {
            A_->multiply_rows_packed(begin, end, p, q);
            add_dots(p.data() + 3 * pack * begin, q.data() + 3 * pack * begin, 3 * (end - begin), sums.first);
          });
      Lanes alpha{}, minus_alpha{}, beta{};
      for (int v = 0; v < width; ++v) {
        if (!running[v]) continue;
        const double pq = product.first[v];
        if (!std::isfinite(pq)) fail("p^T A p = " + number_text(pq), first + v, iteration);
        if (pq <= 0.0) fail("matrix is not positive definite: p^T A p = " + number_text(pq), first + v, iteration);
        alpha[v] = rz[v] / pq;
        minus_alpha[v] = -alpha[v];
      }
      const Sums sums = sum_over_rows(nodes, partial, [&](std::ptrdiff_t begin, std::ptrdiff_t end, Sums& out) {
        const std::ptrdiff_t at = 3 * pack * begin, count = 3 * (end - begin);
        add_scaled(minus_alpha, q.data() + at, r.data() + at, count);
        apply_inverse(inverse_.data(), r.data(), z.data(), begin, end);
        add_dots(r.data() + at, z.data() + at, count, out.first);
        add_dots(r.data() + at, r.data() + at, count, out.second);
      });
      for (int v = 0; v < width; ++v) {
        if (!running[v]) continue;
        Convergence& state = states[static_cast<std::size_t>(first + v)];
        state.iterations = iteration;
        state.residual = std::sqrt(sums.second[v]) / b_norm[v];
        if (!std::isfinite(state.residual))
          fail("residual = " + number_text(state.residual), first + v, iteration);
        state.converged = state.residual <= tolerance;
        running[v] = !state.converged;
        beta[v] = sums.first[v] / rz[v];
        rz[v] = sums.first[v];
      }
      for_chunks(nodes, chunk_rows, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
        const std::ptrdiff_t at = 3 * pack * begin, count = 3 * (end - begin);
        add_scaled(alpha, p.data() + at, x.data() + at, count);
        scale_and_add(beta, z.data() + at, p.data() + at, count);
      });
    }
    for (int v = 0; v < width; ++v) {
      for (std::ptrdiff_t i = 0; i < unknowns; ++i)
        solution(i, first + v) = x[static_cast<std::size_t>(pack * i + v)];
    }
  }
  X = std::move(solution);
  return states;
}

}  // namespace plica

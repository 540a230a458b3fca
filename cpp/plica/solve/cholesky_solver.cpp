#include "plica/solve/cholesky_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"

namespace plica {
namespace {

constexpr int pack = TriangularFactor::pack;

void check_finite(const char* name, double value) {
  if (std::isfinite(value)) return;
  throw SolveFailed(std::string("Cholesky: ") + name + " = " + number_text(value) +
                    "; must be finite. Are the matrix, the right-hand side and the guess finite?");
}

void check_size(const char* name, std::ptrdiff_t size, std::ptrdiff_t rows) {
  if (size != rows)
    throw InvalidInput("Cholesky", name, static_cast<double>(size), "",
                       "the number of rows, " + number_text(static_cast<double>(rows)));
}

}  // namespace

Convergence CholeskySolver::solve(const Vector& b, Guess& guess, double tolerance) const {
  return solve(b, guess, tolerance, [this](const Vector& x, Vector& image) { A_.multiply(x, image); });
}

Convergence CholeskySolver::solve(const Vector& b, Guess& guess, double tolerance, const Product& own) const {
  const auto product = [&](const Vector& x, Vector& image) {
    own(x, image);
    check_size("the product's size()", image.size(), A_.rows());
  };
  check_size("b.size()", b.size(), A_.rows());
  Vector& x = guess.x;
  if (x.size() == 0) {
    x = Vector::Zero(A_.rows());
    guess.product = x;
  }
  check_size("guess.x.size()", x.size(), A_.rows());
  if (guess.product.size() != 0) check_size("guess.product.size()", guess.product.size(), A_.rows());
  const double b_norm = b.norm();
  check_finite("|b|", b_norm);
  Convergence state;
  if (b_norm == 0.0) {
    x.setZero();
    product(x, guess.product);
    state.converged = true;
    return state;
  }
  // A product that was handed over is believed for the first correction alone; the last word is A's own.
  bool believed = guess.product.size() != 0 && !x.isZero(0.0);
  if (guess.product.size() == 0) product(x, guess.product);
  Vector r = b - guess.product, d;
  const auto renew = [&] {
    product(x, guess.product);
    r = b - guess.product;
    state.residual = r.norm() / b_norm;
    check_finite("|b - A x| / |b|", state.residual);
  };
  state.residual = r.norm() / b_norm;
  check_finite("|b - A x| / |b|", state.residual);
  if (believed && state.residual <= tolerance) renew();
  bool refine = true;
  while (state.residual > tolerance && state.iterations < options_.max_iterations) {
    const double before = state.residual;
    if (refine) {
      factor_.solve(r, d);
      ++state.iterations;
    } else {
      correct(r, d, 0.5 * tolerance / before, state.iterations);
    }
    x += d;
    renew();
    if (refine && state.residual > before) {  // the rounded factor led away
      x -= d;
      renew();
    }
    if (!refine && state.residual > 0.5 * before) break;  // round-off is reached
    refine = refine && state.residual <= least_gain * before;
  }
  state.converged = state.residual <= tolerance;
  return state;
}

/// Solves A d = r to |r - A d| <= target |r| by conjugate gradients preconditioned by the factor. As that is
/// rounded, directions are kept conjugate by beta = z^T (r - r_before) / (r_before^T z_before).
void CholeskySolver::correct(Vector& r, Vector& d, double target, int& iterations) const {
  Vector z, p, q, before;
  const double enough = target * r.norm();
  double rz = 0.0;
  d.setZero(r.size());
  while (r.norm() > enough && iterations < options_.max_iterations) {
    ++iterations;
    factor_.solve(r, z);
    if (rz == 0.0)
      p = z;
    else
      p = z + (z.dot(r - before) / rz) * p;
    rz = r.dot(z);
    A_.multiply(p, q);
    const double curvature = p.dot(q);
    check_finite("p^T A p", curvature);
    if (curvature <= 0.0)
      throw SolveFailed("Cholesky: matrix is not positive definite: p^T A p = " + number_text(curvature) +
                        ". Is the body held, and is every element the right way round?");
    const double alpha = p.dot(r) / curvature;
    before = r;
    d += alpha * p;
    r -= alpha * q;
    check_finite("|b - A x| / |b|", r.norm());
  }
}

std::vector<Convergence> CholeskySolver::solve_many(const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                                                    double tolerance) const {
  const std::ptrdiff_t unknowns = A_.rows(), nodes = unknowns / 3;
  check_size("B.rows()", B.rows(), unknowns);
  std::vector<Convergence> states(static_cast<std::size_t>(B.cols()));
  Eigen::MatrixXd solution(unknowns, B.cols());
  const auto length = static_cast<std::size_t>(pack * unknowns);
  std::vector<double> x(length), r(length), d(length);
  for (std::ptrdiff_t first = 0; first < B.cols(); first += pack) {
    const int width = static_cast<int>(std::min<std::ptrdiff_t>(pack, B.cols() - first));
    std::array<double, pack> b_norm{};
    std::array<bool, pack> running{}, slow{};
    std::fill(x.begin(), x.end(), 0.0);
    std::fill(r.begin(), r.end(), 0.0);
    for (int v = 0; v < width; ++v) {
      Convergence& state = states[static_cast<std::size_t>(first + v)];
      b_norm[v] = B.col(first + v).norm();
      check_finite("|b|", b_norm[v]);
      running[v] = b_norm[v] > 0.0;
      state.residual = running[v] ? 1.0 : 0.0;
      for (std::ptrdiff_t i = 0; i < unknowns; ++i) r[static_cast<std::size_t>(pack * i + v)] = B(i, first + v);
    }
    while (std::any_of(running.begin(), running.end(), [](bool on) { return on; })) {
      factor_.solve_packed(r.data(), d.data());
      for (std::ptrdiff_t i = 0; i < unknowns; ++i)
        for (int v = 0; v < pack; ++v)
          if (running[v]) x[static_cast<std::size_t>(pack * i + v)] += d[static_cast<std::size_t>(pack * i + v)];
      for_chunks(nodes, BlockMatrix::chunk_rows, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
        A_.multiply_rows_packed(begin, end, x, r);
        for (std::ptrdiff_t i = 3 * begin; i < 3 * end; ++i)
          for (int v = 0; v < pack; ++v) {
            double& entry = r[static_cast<std::size_t>(pack * i + v)];
            entry = v < width ? B(i, first + v) - entry : 0.0;
          }
      });
      std::array<double, pack> square{};
      for (std::ptrdiff_t i = 0; i < unknowns; ++i)
        for (int v = 0; v < pack; ++v) {
          const double entry = r[static_cast<std::size_t>(pack * i + v)];
          square[v] += entry * entry;
        }
      for (int v = 0; v < width; ++v) {
        if (!running[v]) continue;
        Convergence& state = states[static_cast<std::size_t>(first + v)];
        const double before = state.residual;
        state.residual = std::sqrt(square[v]) / b_norm[v];
        check_finite("|b - A x| / |b|", state.residual);
        ++state.iterations;
        slow[v] = state.residual > std::max(tolerance, least_gain * before);
        running[v] = state.residual > tolerance && !slow[v] && state.iterations < options_.max_iterations;
      }
    }
    for (int v = 0; v < width; ++v) {
      Convergence& state = states[static_cast<std::size_t>(first + v)];
      for (std::ptrdiff_t i = 0; i < unknowns; ++i)
        solution(i, first + v) = x[static_cast<std::size_t>(pack * i + v)];
      state.converged = state.residual <= tolerance;
      if (!slow[v]) continue;
      Guess alone;  // afresh: what helps a single right-hand side helps here
      state = solve(B.col(first + v), alone, tolerance);
      solution.col(first + v) = alone.x;
    }
  }
  X = std::move(solution);
  return states;
}

}  // namespace plica

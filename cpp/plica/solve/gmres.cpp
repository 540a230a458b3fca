#include <algorithm>
#include <cmath>
#include <limits>

#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "plica/solve/krylov.hpp"

namespace plica {
namespace {

constexpr std::ptrdiff_t chunk_size = 4096;

/// w -= h v, then the sum of w_i u_i; in one pass, summed in the order of the chunks.
double subtract_and_dot(Vector& w, double h, const Vector& v, const Vector& u) {
  const std::ptrdiff_t n = w.size();
  std::vector<double> partial(static_cast<std::size_t>((n + chunk_size - 1) / chunk_size), 0.0);
  for_chunks(n, chunk_size, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t chunk) {
    const std::ptrdiff_t count = end - begin;
    if (h != 0.0) w.segment(begin, count) -= h * v.segment(begin, count);
    partial[static_cast<std::size_t>(chunk)] = w.segment(begin, count).dot(u.segment(begin, count));
  });
  double total = 0.0;
  for (double part : partial) total += part;
  return total;
}

double norm(Vector& v) { return std::sqrt(subtract_and_dot(v, 0.0, v, v)); }

void check(std::ptrdiff_t size, std::ptrdiff_t expected, const char* name) {
  if (size != expected) {
    throw InvalidInput("gmres", name, static_cast<double>(size), "",
                       "the length of b, " + number_text(static_cast<double>(expected)));
  }
}

void check_finite(double value, const char* name, int iteration) {
  if (!std::isfinite(value)) {
    throw SolveFailed(std::string("gmres: ") + name + " = " + number_text(value) + " in iteration " +
                      number_text(iteration) +
                      "; must be finite. Are the operator, the right-hand side and the start finite?");
  }
}

/// The least-squares problem min |beta e1 - H y| of one cycle, kept triangular by Givens rotations.
class Hessenberg {
 public:
  Hessenberg(int restart, double beta)
      : H_(Eigen::MatrixXd::Zero(restart + 1, restart)), cosine_(restart), sine_(restart) {
    g_ = Vector::Zero(restart + 1);
    g_[0] = beta;
  }
  double& operator()(int i, int j) { return H_(i, j); }
  /// Rotates column j, complete with H(j + 1, j); returns the residual norm of the first j + 1 columns.
  double rotate(int j) {
    for (int i = 0; i < j; ++i) apply(i, H_(i, j), H_(i + 1, j));
    const double length = std::hypot(H_(j, j), H_(j + 1, j));
    cosine_[j] = length > 0.0 ? H_(j, j) / length : 1.0;
    sine_[j] = length > 0.0 ? H_(j + 1, j) / length : 0.0;
    apply(j, H_(j, j), H_(j + 1, j));
    apply(j, g_[j], g_[j + 1]);
    return std::abs(g_[j + 1]);
  }
  /// The minimiser with `columns` columns, the last of them left out where the operator maps it to nothing new.
  Vector solve(int columns) const {
    const double scale = H_.topLeftCorner(columns, columns).cwiseAbs().maxCoeff();
    if (std::abs(H_(columns - 1, columns - 1)) <= std::numeric_limits<double>::epsilon() * scale) --columns;
    return H_.topLeftCorner(columns, columns).triangularView<Eigen::Upper>().solve(g_.head(columns));
  }

 private:
  void apply(int i, double& upper, double& lower) const {
    const double rotated = cosine_[i] * upper + sine_[i] * lower;
    lower = cosine_[i] * lower - sine_[i] * upper;
    upper = rotated;
  }

  Eigen::MatrixXd H_;
  Vector cosine_, sine_, g_;
};

}  // namespace

Convergence gmres(const std::function<void(const Vector&, Vector&)>& apply, const Vector& diagonal,
                  const Vector& b, Vector& x, const KrylovOptions& options, int restart) {
  options.validate();
  const std::ptrdiff_t n = b.size();
  if (restart < 1) throw InvalidInput("gmres", "restart", restart, "", ">= 1");
  check(diagonal.size(), n, "diagonal.size()");
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    if (!(diagonal[i] > 0.0 && std::isfinite(diagonal[i]))) {
      throw InvalidInput("gmres", "diagonal[" + number_text(static_cast<double>(i)) + "]", diagonal[i], "",
                         "> 0 and finite");
    }
  }
  if (x.size() == 0) x = Vector::Zero(n);
  check(x.size(), n, "x.size()");

  Convergence state;
  const Vector scale = diagonal.cwiseSqrt().cwiseInverse();
  Vector scaled = scale.cwiseProduct(b);
  const double b_norm = norm(scaled);
  check_finite(b_norm, "|S b|", 0);
  if (b_norm == 0.0) {
    x.setZero();
    state.converged = true;
    return state;
  }

  const int length = static_cast<int>(std::min<std::ptrdiff_t>(restart, n));
  std::vector<Vector> basis;
  basis.reserve(static_cast<std::size_t>(length + 1));
  Vector image(n), direction(n);
  const auto residual_vector = [&]() -> Vector {
    if ((x.array() == 0.0).all()) return scaled;
    apply(x, image);
    check(image.size(), n, "operator(x).size()");
    return scale.cwiseProduct(b - image);
  };

  Vector r = residual_vector();
  double beta = norm(r);
  state.residual = beta / b_norm;
  check_finite(state.residual, "|S (b - Op x)| / |S b|", 0);
  while (!(state.converged = state.residual <= options.tolerance) && state.iterations < options.max_iterations) {
    basis.clear();
    basis.push_back(r / beta);
    Hessenberg H(length, beta);
    int columns = 0;
    bool ended = false;
    while (!ended && columns < length && state.iterations < options.max_iterations) {
      const int j = columns;
      direction = scale.cwiseProduct(basis[j]);
      apply(direction, image);
      check(image.size(), n, "operator(x).size()");
      Vector w = scale.cwiseProduct(image);
      const double w_norm = norm(w);
      check_finite(w_norm, "|S Op S v|", state.iterations + 1);
      H(0, j) = subtract_and_dot(w, 0.0, w, basis[0]);
      for (int i = 1; i <= j; ++i) H(i, j) = subtract_and_dot(w, H(i - 1, j), basis[i - 1], basis[i]);
      H(j + 1, j) = std::sqrt(subtract_and_dot(w, H(j, j), basis[j], w));
      ++columns;
      ++state.iterations;
      // Nothing new beside rounding: the Krylov space is complete, and its best element is the solution
      // wherever the operator is regular on it.
      const double next = H(j + 1, j);
      ended = next <= 10.0 * std::numeric_limits<double>::epsilon() * w_norm;
      if (ended) H(j + 1, j) = 0.0;
      ended = H.rotate(j) <= options.tolerance * b_norm || ended;
      if (!ended) basis.push_back(w / next);
    }
    const Vector y = H.solve(columns);
    direction.setZero();
    for (std::ptrdiff_t i = 0; i < y.size(); ++i) direction += y[i] * basis[static_cast<std::size_t>(i)];
    x += scale.cwiseProduct(direction);
    const double before = state.residual;
    r = residual_vector();
    beta = norm(r);
    state.residual = beta / b_norm;
    check_finite(state.residual, "|S (b - Op x)| / |S b|", state.iterations);
    if (!(state.residual < before)) break;
  }
  state.converged = state.residual <= options.tolerance;
  return state;
}

}  // namespace plica

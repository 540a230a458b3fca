#include "plica/dynamics/stable_step.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "plica/core/constants.hpp"
#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"

namespace plica {

namespace {

/// A direction drawn evenly among those of the free unknowns; the same at every call.
Vector random_start(const Vector& scale) {
  std::mt19937_64 bits(1992);
  const auto uniform = [&] { return (static_cast<double>(bits() >> 11) + 0.5) * 0x1p-53; };
  Vector start = Vector::Zero(scale.size());
  for (std::ptrdiff_t i = 0; i < start.size(); ++i) {
    if (!(scale[i] > 0)) continue;
    const double radius = std::sqrt(-2 * std::log(uniform()));
    start[i] = radius * std::cos(2 * pi * uniform());
  }
  return start / start.norm();
}

/// Lanczos steps after which the largest eigenvalue is missed by more than the share eps with a probability below
/// delta: sqrt(n) exp(-(2 k - 1) sqrt(eps)) but for a factor (Kuczynski and Wozniakowski 1992).
int lanczos_steps(std::ptrdiff_t unknowns, double eps, double delta) {
  constexpr double factor = 1.648;
  const double digits = std::log(factor * std::sqrt(static_cast<double>(unknowns)) / delta);
  return static_cast<int>(std::ceil(0.5 * (digits / std::sqrt(eps) + 1)));
}

}  // namespace

StableStep::StableStep(const Vector& inverse_mass, Slopes slopes)
    : scale_(inverse_mass.cwiseSqrt()), slopes_(std::move(slopes)) {}

StableStep::Slopes StableStep::slopes_of(const BlockMatrix& K, const std::optional<BlockMatrix>& C) {
  return [&K, &C](const Vector& x, double elastic, double viscous) {
    Vector image(x.size()), rates(C ? x.size() : 0);
    for_chunks(K.pattern()->rows(), BlockMatrix::chunk_rows,
               [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
                 const std::ptrdiff_t at = 3 * begin, count = 3 * (end - begin);
                 K.multiply_rows(begin, end, x, image);
                 image.segment(at, count) *= elastic;
                 if (!C) return;
                 C->multiply_rows(begin, end, x, rates);
                 image.segment(at, count) += viscous * rates.segment(at, count);
               });
    return image;
  };
}

Vector StableStep::product(const Vector& x, double h) const {
  return scale_.cwiseProduct(slopes_(scale_.cwiseProduct(x), 0.25 * h * h, h));
}

double StableStep::eigenvalue(double h) const {
  constexpr double eps = 0.01, delta = 1e-9;
  const std::ptrdiff_t unknowns = (scale_.array() > 0).count();
  if (unknowns == 0) return 0.0;
  const int steps = lanczos_steps(unknowns, eps, delta);
  Vector diagonal(steps), below(steps), q = random_start(scale_), before = Vector::Zero(q.size());
  int done = 0;
  double beta = 0.0, largest = 0.0;
  while (done < steps) {
    Vector next = product(q, h) - beta * before;
    const double alpha = next.dot(q);
    next -= alpha * q;
    beta = next.norm();
    diagonal[done] = alpha;
    below[done++] = beta;
    largest = std::max(largest, std::abs(alpha) + beta);
    if (!(beta > 1e-12 * largest)) break;  // the eigenvectors in the start are used up: exact
    before = std::exchange(q, next / beta);
  }
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz;
  ritz.computeFromTridiagonal(diagonal.head(done), below.head(done - 1), Eigen::EigenvaluesOnly);
  return ritz.eigenvalues()[done - 1] / (1 - eps);
}

double StableStep::largest(double further) const {
  // The eigenvalue grows as a power of h between 1 (viscosity) and 2: secants of its logarithm.
  constexpr int most = 20;
  constexpr double close = 1e-4;
  const auto load = [&](double h) { return eigenvalue(h) + 0.25 * h * h * further; };
  double h = 1.0, found = load(h), power = 2.0;
  if (!(found > 0)) throw InvalidInput("Simulation: central differences: no unknown is free and has stiffness.");
  for (int k = 0; k < most && std::abs(found - 1) > close; ++k) {
    const double next = h * std::pow(found, -1 / power), of_next = load(next);
    if (next != h) power = std::clamp(std::log(of_next / found) / std::log(next / h), 1.0, 2.0);
    h = next;
    found = of_next;
  }
  return found > 1 ? h / found : h;
}

}  // namespace plica

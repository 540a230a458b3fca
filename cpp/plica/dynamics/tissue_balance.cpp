#include "plica/dynamics/tissue_balance.hpp"

#include <cmath>
#include <limits>

#include "plica/core/eigenpairs.hpp"
#include "plica/core/error.hpp"

namespace plica {

namespace {

constexpr std::size_t most_kept = 20;
constexpr int most_halvings = 12, most_retreats = 12;
constexpr double much_worse = 100;  // in energy: a residual ten times as large
constexpr double distinct = 1e-10;  // least eigenvalue of the differences' products, of the largest

Guess between(const Guess& one, const Guess& other) {
  return {0.5 * (one.x + other.x), 0.5 * (one.product + other.product)};
}

}  // namespace

TissueBalance::TissueBalance(const ExcessForce& law, Weighted weighted, Guess first, std::function<Guess()> still)
    : law_(law),
      weighted_(std::move(weighted)),
      still_(std::move(still)),
      least_(std::numeric_limits<double>::infinity()) {
  take(std::move(first));
}

const Guess& TissueBalance::best() {
  if (best_.x.size() == 0) best_ = still_();
  return best_;
}

void TissueBalance::take(Guess guess) {
  Vector U, V;
  std::optional<std::int32_t> cell;
  for (int halved = 0; halved <= most_halvings; ++halved) {
    if (halved > 0) guess = between(guess, best());
    weighted_(guess.x, U, V);
    ++evaluations_;
    cell = law_.at(U, V, force_);
    if (cell) continue;
    guess_ = std::move(guess);
    sum_ = force_.sum();
    return;
  }
  law_.fail_inside_out(*cell, " however little the step moves it");
}

bool TissueBalance::retreat() {
  if (++retreats_ > most_retreats) return false;
  take(between(guess_, best()));
  return true;
}

bool TissueBalance::settled(Guess reached) {
  ++iterations_;
  Guess residual{reached.x - guess_.x, reached.product - guess_.product};
  const double left = residual.product.norm(), enough = law_.options().tolerance * force_.whole + force_.round_off;
  if (left <= enough) return true;
  if (!std::isfinite(left) || iterations_ >= law_.options().max_iterations) {
    std::ptrdiff_t worst = 0;
    residual.product.cwiseAbs().maxCoeff(&worst);
    throw SolveFailed("tissue at finite strain: the force of the tissue is out of balance by " +
                      number_text(left / force_.whole) + " of it after " + std::to_string(iterations_) +
                      " iterations, most " + law_.node_text(worst) + "; must be at most " +
                      number_text(law_.options().tolerance) +
                      ". Take a shorter time.step, less pressure, or stiffer tissue there.");
  }
  const double energy = residual.x.dot(residual.product);
  const bool worse = energy > much_worse * least_;
  if (energy < least_) {
    least_ = energy;
    best_ = guess_;
  }
  reached_.push_back(std::move(reached));
  residual_.push_back(std::move(residual));
  if (reached_.size() > most_kept) {
    reached_.erase(reached_.begin());
    residual_.erase(residual_.begin());
  }
  take(worse ? between(guess_, best_) : mixed());
  return false;
}

Guess TissueBalance::mixed() const {
  const auto count = static_cast<std::ptrdiff_t>(residual_.size()) - 1;
  Guess next = reached_.back();
  if (count == 0) return next;
  const auto n = static_cast<std::size_t>(count);
  std::vector<Guess> change;
  for (std::size_t j = 0; j < n; ++j)
    change.push_back({residual_[j + 1].x - residual_[j].x, residual_[j + 1].product - residual_[j].product});
  Eigen::MatrixXd products(count, count);
  Vector along(count), scale(count);
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const Vector& x = change[static_cast<std::size_t>(i)].x;
    for (std::ptrdiff_t j = 0; j < count; ++j) products(i, j) = x.dot(change[static_cast<std::size_t>(j)].product);
    along[i] = x.dot(residual_.back().product);
    scale[i] = products(i, i) > 0 ? 1 / std::sqrt(products(i, i)) : 0.0;
  }
  products = (scale.asDiagonal() * (0.5 * (products + products.transpose())) * scale.asDiagonal()).eval();
  const Eigenpairs modes = symmetric_eigenpairs(products);
  const Vector by_mode = modes.vectors.transpose() * (scale.asDiagonal() * along);
  Vector weights = Vector::Zero(count);
  for (std::ptrdiff_t k = 0; k < count; ++k)
    if (modes.values[k] > distinct * modes.values[count - 1])
      weights += by_mode[k] / modes.values[k] * modes.vectors.col(k);
  weights = scale.asDiagonal() * weights;
  for (std::size_t j = 0; j < n; ++j) {
    const double weight = weights[static_cast<std::ptrdiff_t>(j)];
    next.x -= weight * (reached_[j + 1].x - reached_[j].x);
    next.product -= weight * (reached_[j + 1].product - reached_[j].product);
  }
  return next;
}

}  // namespace plica

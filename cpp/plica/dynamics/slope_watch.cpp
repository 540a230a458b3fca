#include "plica/dynamics/slope_watch.hpp"

#include <algorithm>
#include <cmath>

namespace plica {

namespace {

constexpr std::int64_t most_steps_between_looks = 4;
constexpr double faster = 1.0;  // motion than at the last look asks for another

}  // namespace

SlopeWatch::SlopeWatch(const Motion& motion, const Vector& inverse_mass)
    : motion_(motion), inverse_mass_(inverse_mass), bound_(motion.excess()->mesh(), motion.excess()->tissue()) {}

StableStep SlopeWatch::stable_at(const Vector& u) const {
  const ExcessForce& law = *motion_.excess();
  return {inverse_mass_, [&law, &u, force = law.elastic(u)](const Vector& x, double elastic, double viscous) {
            return law.slopes(u, force, x, elastic, viscous);
          }};
}

std::optional<SlopeWatch::TooLong> SlopeWatch::at(const Vector& u, std::int64_t step, double further) {
  const double h = motion_.step(), elastic = 0.25 * h * h, beside = elastic * further;
  const bool follows = step == last_ + 1;
  last_ = step;
  const double motion = follows && last_u_.size() > 0 ? (u - last_u_).cwiseAbs().maxCoeff() : 0.0;
  last_u_ = u;
  if (known_.size() > 0 && (!follows || step >= next_look_ || motion > faster * moved_)) {
    moved_ = motion;
    const double changed = bound_.change(known_, u, elastic, h).value;
    // Half of what is left may go until the next look, at the rate of now.
    const double steps = static_cast<double>(std::max<std::int64_t>(step - looked_, 1));
    const double rate = std::abs(changed - change_) / steps, left = 1 - eigenvalue_ - changed - beside;
    const double until = follows && rate > 0 ? 0.5 * left / rate : follows ? most_steps_between_looks : 1;
    next_look_ = step + static_cast<std::int64_t>(std::clamp<double>(until, 1, most_steps_between_looks));
    looked_ = step;
    change_ = changed;
  }
  if (known_.size() > 0 && eigenvalue_ + change_ + beside <= 1) return std::nullopt;
  const StableStep stable = stable_at(u);
  eigenvalue_ = stable.eigenvalue(h);
  known_ = u;
  change_ = 0.0;
  moved_ = motion;
  looked_ = step;
  next_look_ = step + 1;
  if (eigenvalue_ + beside <= 1) return std::nullopt;
  return TooLong{stable.largest(further), eigenvalue_ > 1, bound_.at(u, elastic, h).cell};
}

}  // namespace plica

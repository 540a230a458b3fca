#include "plica/contact/friction.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "plica/core/constants.hpp"
#include "plica/core/require.hpp"

namespace plica {

namespace {

using Vector2 = Eigen::Vector2d;

double cross(const Vector2& a, const Vector2& b) { return a[0] * b[1] - a[1] * b[0]; }

/// One contact: block B of W, and b, its gap and slips without its own force.
class OneContact {
 public:
  OneContact(const Matrix3& B, const Vector3& b, double mu) : B_(B), b_(b), mu_(mu) {}

  /// Its force (normal, two tangents); `before` names the slip direction to look for first.
  Vector3 force(const Vector3& before) const {
    if (b_[0] >= 0) return Vector3::Zero();
    const Vector3 stick = B_.partialPivLu().solve(-b_);
    if (stick[0] >= 0 && stick.tail<2>().norm() <= mu_ * stick[0]) return stick;
    return slipping(before.tail<2>().norm() > 0 ? before.tail<2>() : stick.tail<2>());
  }

 private:
  /// The force whose friction points along d (unit) at its limit and closes the gap.
  Vector3 along(const Vector2& d) const {
    const double normal = -b_[0] / (B_(0, 0) + mu_ * B_.block<1, 2>(0, 1).dot(d.transpose()));
    Vector3 p;
    p << normal, mu_ * normal * d;
    return p;
  }
  Vector2 slip(const Vector3& p) const { return B_.bottomRows<2>() * p + b_.tail<2>(); }
  /// Zero where the slip is along d.
  double turn(double angle) const {
    const Vector2 d(std::cos(angle), std::sin(angle));
    return cross(d, slip(along(d)));
  }

  /// The direction against which the contact slips, nearest to `first`: a sign change of turn(), by bisection.
  Vector3 slipping(const Vector2& first) const {
    constexpr int arcs = 32;
    constexpr double arc = 2 * pi / arcs;
    const double start = std::atan2(first[1], first[0]);
    for (int k = 0; k < arcs; ++k) {  // arcs to the left and right of `first` in turn
      double low = start + arc * (k % 2 ? -(k + 1) / 2 : k / 2), high = low + arc;
      double at_low = turn(low);
      const double at_high = turn(high);
      if ((at_low > 0) == (at_high > 0)) continue;
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high), at_middle = turn(middle);
        if ((at_middle > 0) == (at_low > 0)) {
          low = middle;
          at_low = at_middle;
        } else {
          high = middle;
        }
      }
      const Vector2 d(std::cos(low), std::sin(low));
      const Vector3 p = along(d);
      if (p[0] >= 0 && d.dot(slip(p)) <= 0) return p;
    }
    return along(first.normalized());
  }

  Matrix3 B_;
  Vector3 b_;
  double mu_;
};

/// How far contact i is from Coulomb's law, m.
double violation(double p_n, const Vector2& p_t, double w_n, const Vector2& w_t, double mu) {
  if (p_n < 0 || (p_n == 0 && !p_t.isZero(0))) return std::numeric_limits<double>::infinity();
  if (p_n == 0) return std::max(0.0, -w_n);
  const double limit = mu * p_n, friction = p_t.norm();
  if (friction < limit * (1 - 1e-9)) return std::max(std::abs(w_n), w_t.norm());
  const Vector2 d = friction > 0 ? Vector2(p_t / friction) : Vector2::Zero();
  return std::max({std::abs(w_n), std::abs(cross(d, w_t)), d.dot(w_t)});
}

}  // namespace

Complementarity solve_coulomb(Eigen::MatrixXd W, const Vector& q, double mu, Vector start, double gap_tolerance,
                              int most_sweeps) {
  const std::ptrdiff_t count = q.size() / 3;
  require_size("solve_coulomb", "q", q.size(), 3 * count);
  require_size("solve_coulomb", "the rows of W", W.rows(), q.size());
  require_size("solve_coulomb", "the columns of W", W.cols(), q.size());
  require_size("solve_coulomb", "the start", start.size(), q.size());
  if (count == 0) return {Vector(), {}, 0, true};
  W.diagonal().array() += shared_compliance * W.diagonal().maxCoeff();
  Complementarity result;
  Vector p = std::move(start), w = W * p + q;
  const auto rows = [count](std::ptrdiff_t i) {
    return std::array<std::ptrdiff_t, 3>{i, count + 2 * i, count + 2 * i + 1};
  };
  while (!result.converged && result.pivots < most_sweeps) {
    ++result.pivots;
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const auto own = rows(i);
      Matrix3 B;
      Vector3 before, b;
      for (int r = 0; r < 3; ++r) {
        before[r] = p[own[r]];
        for (int c = 0; c < 3; ++c) B(r, c) = W(own[r], own[c]);
      }
      for (int r = 0; r < 3; ++r) b[r] = w[own[r]];
      b -= B * before;
      const Vector3 now = OneContact(B, b, mu).force(before);
      for (int c = 0; c < 3; ++c) {
        if (now[c] == before[c]) continue;
        w += (now[c] - before[c]) * W.col(own[c]);
        p[own[c]] = now[c];
      }
    }
    w = W * p + q;
    double worst = 0;
    for (std::ptrdiff_t i = 0; i < count; ++i)
      worst = std::max(worst, violation(p[i], p.segment<2>(count + 2 * i), w[i], w.segment<2>(count + 2 * i), mu));
    result.converged = worst <= gap_tolerance;
  }
  result.force = std::move(p);
  result.active.assign(static_cast<std::size_t>(count), 0);
  for (std::ptrdiff_t i = 0; i < count; ++i) result.active[static_cast<std::size_t>(i)] = result.force[i] > 0;
  return result;
}

}  // namespace plica

#include <doctest/doctest.h>

#include <Eigen/QR>
#include <random>

#include "plica/contact/friction.hpp"

using namespace plica;

namespace {

/// A symmetric positive definite W (3 r, 3 r) of condition about `spread`, seeded.
Eigen::MatrixXd random_compliance(std::ptrdiff_t rows, double spread, std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd any(rows, rows);
  for (std::ptrdiff_t i = 0; i < any.size(); ++i) any.data()[i] = normal(random);
  const Eigen::MatrixXd Q = any.householderQr().householderQ();
  const Vector d = Vector::LinSpaced(rows, 0, 1).unaryExpr([&](double s) { return std::pow(spread, -s); });
  return Q * d.asDiagonal() * Q.transpose();
}

}  // namespace

TEST_CASE("Coulomb's law holds for every contact of random compliances") {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  constexpr double tolerance = 1e-6;  // rows are regularised by 1e-9, forces reach some tens
  int open = 0, stuck = 0, slipping = 0;
  for (int trial = 0; trial < 20; ++trial) {
    CAPTURE(trial);
    const std::ptrdiff_t count = 6;
    const double mu = 0.3 + 0.02 * trial;
    const Eigen::MatrixXd W = random_compliance(3 * count, 10, random);
    Vector q(3 * count);
    for (std::ptrdiff_t i = 0; i < q.size(); ++i) q[i] = normal(random) - (i < count ? 1.0 : 0.0);
    const Complementarity found = solve_coulomb(W, q, mu, Vector::Zero(3 * count), 1e-8, 10000);
    REQUIRE(found.converged);
    const Vector w = W * found.force + q;
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const double p = found.force[i];
      const Eigen::Vector2d friction = found.force.segment<2>(count + 2 * i), slip = w.segment<2>(count + 2 * i);
      CHECK(p >= 0);
      CHECK(w[i] >= -tolerance);
      CHECK(p * w[i] < tolerance);
      CHECK(friction.norm() <= mu * p * (1 + 1e-9));
      if (p == 0) {
        ++open;
      } else if (friction.norm() < mu * p * (1 - 1e-9)) {
        CHECK(slip.norm() < tolerance);
        ++stuck;
      } else {
        CHECK(friction.dot(slip) <= tolerance);
        CHECK(std::abs(friction.x() * slip.y() - friction.y() * slip.x()) < tolerance);
        ++slipping;
      }
    }
  }
  CHECK(open > 10);
  CHECK(stuck > 10);
  CHECK(slipping > 10);
}

TEST_CASE("one contact of unit compliance: friction holds up to the cone, and then slips along the push") {
  const Eigen::MatrixXd W = Eigen::MatrixXd::Identity(3, 3);
  const double mu = 0.5;
  const auto force = [&](double x, double y) {
    Vector q(3);
    q << -2.0, x, y;
    const Complementarity found = solve_coulomb(W, q, mu, Vector::Zero(3), 1e-8, 100);
    REQUIRE(found.converged);
    return found.force;
  };
  // Pushed in by 2, the normal force is 2 and friction carries up to 1.
  CHECK((force(0.6, -0.7) - Vector3(2, -0.6, 0.7)).norm() < 1e-8);
  CHECK((force(3.0, 4.0) - Vector3(2, -0.6, -0.8)).norm() < 1e-8);
}

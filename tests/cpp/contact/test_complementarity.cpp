#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "plica/contact/complementarity.hpp"
#include "plica/core/error.hpp"

using namespace plica;

namespace {

struct Random {
  std::mt19937 generator{11};
  std::normal_distribution<double> normal;
  Eigen::MatrixXd matrix(int rows, int columns) {
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(generator); });
  }
};

/// Every active set is tried; the one whose forces push and whose gaps are open is the answer. W definite.
Vector enumerate(const Eigen::MatrixXd& W, const Vector& q) {
  const auto n = static_cast<int>(q.size());
  for (int set = 0; set < (1 << n); ++set) {
    std::vector<std::ptrdiff_t> rows;
    for (int i = 0; i < n; ++i)
      if (set >> i & 1) rows.push_back(i);
    Vector p = Vector::Zero(n);
    if (!rows.empty()) {
      const auto m = static_cast<std::ptrdiff_t>(rows.size());
      Eigen::MatrixXd part(m, m);
      Vector right(m);
      for (std::ptrdiff_t i = 0; i < m; ++i) {
        right[i] = -q[rows[i]];
        for (std::ptrdiff_t j = 0; j < m; ++j) part(i, j) = W(rows[i], rows[j]);
      }
      const Vector solution = part.llt().solve(right);
      for (std::ptrdiff_t i = 0; i < m; ++i) p[rows[i]] = solution[i];
    }
    Vector w = W * p + q;
    for (const auto i : rows) w[i] = 0;
    if (p.minCoeff() >= 0 && w.minCoeff() >= 0) return p;
  }
  FAIL("no active set is consistent");
  return {};
}

std::vector<char> none(std::ptrdiff_t n) { return std::vector<char>(static_cast<std::size_t>(n), 0); }

}  // namespace

TEST_CASE("pivoting finds the forces that trying every active set finds") {
  Random random;
  for (int k = 0; k < 200; ++k) {
    const int n = 1 + k % 8;
    const Eigen::MatrixXd B = random.matrix(n, n);
    const Eigen::MatrixXd W = B * B.transpose() + 0.05 * Eigen::MatrixXd::Identity(n, n);
    const Vector q = random.matrix(n, 1);
    std::vector<char> guess = none(n);
    for (auto& g : guess) g = static_cast<char>(random.generator() % 2);
    const Complementarity found = solve_complementarity(W, q, guess, 0.0, 1000);
    REQUIRE(found.converged);
    const Vector exact = enumerate(W, q);
    // 1e-9 of the largest diagonal entry is added; its effect grows with the condition, here at most about 1e3.
    CHECK((found.force - exact).norm() <= 1e-6 * (1 + exact.norm()));
  }
}

TEST_CASE("rows that repeat others share the force and the motion is unique") {
  Random random;
  for (int k = 0; k < 100; ++k) {
    const int distinct = 2 + k % 4, n = distinct + 3;
    Eigen::MatrixXd G(n, 6);
    G.topRows(distinct) = random.matrix(distinct, 6);
    Vector q(n);
    q.head(distinct) = random.matrix(distinct, 1);
    for (int i = 0; i < 3; ++i) {  // three rows repeat earlier ones
      G.row(distinct + i) = G.row(i % distinct);
      q[distinct + i] = q[i % distinct];
    }
    const Complementarity found = solve_complementarity(G * G.transpose(), q, none(n), 1e-9, 1000);
    REQUIRE(found.converged);
    const Eigen::MatrixXd part = G.topRows(distinct);
    const Eigen::MatrixXd W = part * part.transpose();
    const Vector exact = enumerate(W, q.head(distinct));
    const Vector moved = part.transpose() * exact, found_moved = G.transpose() * found.force;
    CHECK((moved - found_moved).norm() <= 1e-6 * (1 + moved.norm()));  // 1e-9 times W's condition
    CHECK(found.force.minCoeff() >= 0);
  }
}

TEST_CASE("the guess changes the way and not the answer") {
  Random random;
  const Eigen::MatrixXd B = random.matrix(30, 30);
  const Eigen::MatrixXd W = B * B.transpose() + 0.1 * Eigen::MatrixXd::Identity(30, 30);
  const Vector q = random.matrix(30, 1);
  const Complementarity cold = solve_complementarity(W, q, none(30), 0.0, 1000);
  const Complementarity warm = solve_complementarity(W, q, cold.active, 0.0, 1000);
  CHECK(warm.pivots == 1);
  CHECK(cold.force == warm.force);
  CHECK(cold.force.minCoeff() >= 0);
  const double added = 1.01e-9 * W.diagonal().maxCoeff() * cold.force.maxCoeff();  // the regularisation's gap
  CHECK((W * cold.force + q).minCoeff() > -added);
  CHECK(std::abs(cold.force.dot(W * cold.force + q)) <= added * cold.force.sum());
}

TEST_CASE("open gaps need no force") {
  const Complementarity found =
      solve_complementarity(Eigen::MatrixXd::Identity(3, 3), Vector::Constant(3, 0.1), none(3), 0.0, 1000);
  CHECK(found.force.isZero(0));
}

TEST_CASE("closed rows without compliance are an error") {
  const Eigen::MatrixXd W = Eigen::MatrixXd::Zero(2, 2);  // both bodies fully fixed
  CHECK_THROWS_AS(solve_complementarity(W, Vector::Constant(2, -1.0), none(2), 0.0, 1000), SolveFailed);
}

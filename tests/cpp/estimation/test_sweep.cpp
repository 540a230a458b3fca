// Impulse responses and their derivatives against dense marching.
#include <doctest/doctest.h>

#include <Eigen/LU>
#include <algorithm>

#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "plica/estimation/sweep.hpp"

using namespace plica;
using namespace plica::estimation;

namespace {

constexpr double alpha = -0.2, step = 0.05;
constexpr double beta = 0.25 * (1 - alpha) * (1 - alpha), gamma = 0.5 - alpha;

/// A chain of nodes whose springs couple all components; the first node is held.
struct Chain {
  Pattern pattern;
  NodalMatrix M;
  BlockMatrix K, C, dK, dC;
  Supports supports;

  explicit Chain(std::int32_t nodes)
      : pattern(make(nodes)), M(pattern), K(pattern), C(pattern), dK(pattern), dC(pattern), supports(nodes) {
    supports.fix(0);
    supports.fix(nodes - 1, 2);
    for (std::int32_t i = 0; i < nodes; ++i) M.values()[entry(i, i)] = 1 + 0.1 * i;
    for (std::int32_t i = 0; i + 1 < nodes; ++i) {
      Matrix3 spring;
      spring << 40, 5, 3, 5, 50 + i, -4, 3, -4, 30;
      add(K, i, spring);
      add(C, i, 0.02 * spring);
      if (i >= nodes / 2) {  // the parameter is that of the second half
        add(dK, i, 0.5 * spring);
        add(dC, i, 0.03 * spring);
      }
    }
  }

  static Pattern make(std::int32_t nodes) {
    auto p = std::make_shared<NodePattern>();
    p->row_start.push_back(0);
    for (std::int32_t i = 0; i < nodes; ++i) {
      for (std::int32_t j = std::max(0, i - 1); j <= std::min(nodes - 1, i + 1); ++j) p->column.push_back(j);
      p->row_start.push_back(static_cast<std::int32_t>(p->column.size()));
    }
    return p;
  }
  std::size_t entry(std::int32_t i, std::int32_t j) const { return static_cast<std::size_t>(pattern->find(i, j)); }
  void add(BlockMatrix& A, std::int32_t i, const Matrix3& S) const {
    for (const auto& [r, c, sign] :
         {std::tuple{i, i, 1.0}, {i + 1, i + 1, 1.0}, {i, i + 1, -1.0}, {i + 1, i, -1.0}})
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) A.block(static_cast<std::ptrdiff_t>(entry(r, c)))[3 * a + b] += sign * S(a, b);
  }
};

/// The same by dense matrices of the free unknowns, K and C moved by `shift` along the direction. (steps,
/// unknowns).
RowMatrix marched(const Chain& chain, const Vector& force, double shift, std::ptrdiff_t steps) {
  const Eigen::MatrixXd all_K =
                            Eigen::MatrixXd(chain.K.to_sparse()) + shift * Eigen::MatrixXd(chain.dK.to_sparse()),
                        all_C =
                            Eigen::MatrixXd(chain.C.to_sparse()) + shift * Eigen::MatrixXd(chain.dC.to_sparse()),
                        all_M = chain.M.to_sparse();
  std::vector<int> free;
  for (int k = 0; k < all_K.rows(); ++k)
    if (!chain.supports.fixed(k)) free.push_back(k);
  const Eigen::MatrixXd K = all_K(free, free), C = all_C(free, free), M = all_M(free, free);
  const auto A = (M + (1 + alpha) * (gamma * step * C + beta * step * step * K)).eval().partialPivLu();
  Vector u = Vector::Zero(K.rows()), v = u, a = u;
  RowMatrix out = RowMatrix::Zero(steps, all_K.rows());
  for (std::ptrdiff_t s = 0; s < steps; ++s) {
    const Vector ut = u + step * v + step * step * (0.5 - beta) * a, vt = v + (1 - gamma) * step * a;
    Vector f = -K * ((1 + alpha) * ut - alpha * u) - C * ((1 + alpha) * vt - alpha * v);
    if (s == 0) f += force(free);
    a = A.solve(f);
    u = ut + beta * step * step * a;
    v = vt + gamma * step * a;
    for (std::size_t k = 0; k < free.size(); ++k) out(s, free[k]) = u[static_cast<std::ptrdiff_t>(k)];
  }
  return out;
}

Indices everything(std::ptrdiff_t unknowns) {
  return Indices::LinSpaced(unknowns, 0, static_cast<std::int32_t>(unknowns) - 1);
}

RowMatrix swept(const Chain& chain, const RowMatrix& patterns, std::ptrdiff_t steps, double tolerance = 1e-13,
                const FactorPlan* plan = nullptr) {
  const std::optional<BlockMatrix> C = chain.C;
  const LinearMotion motion{chain.M, C, chain.K, chain.supports, alpha, beta, gamma, step};
  const std::vector<Direction> directions{{without_zero_blocks(chain.dK), without_zero_blocks(chain.dC)}};
  return impulse_responses(motion, patterns, directions, everything(chain.K.rows()), steps, tolerance, plan);
}

}  // namespace

TEST_CASE("responses and derivatives are those of dense marching, in more columns than a pack") {
  const Chain chain(9);
  const std::ptrdiff_t n = chain.K.rows(), q = 11, steps = 60;
  std::srand(4);
  const RowMatrix patterns = RowMatrix::Random(n, q);
  const RowMatrix found = swept(chain, patterns, steps);
  REQUIRE(found.cols() == n * 2 * q);
  for (std::ptrdiff_t i = 0; i < q; ++i) {
    const Vector force = patterns.col(i);
    const RowMatrix u = marched(chain, force, 0, steps);
    const double h = 1e-3;
    const RowMatrix du = (marched(chain, force, -2 * h, steps) - 8 * marched(chain, force, -h, steps) +
                          8 * marched(chain, force, h, steps) - marched(chain, force, 2 * h, steps)) /
                         (12 * h);
    RowMatrix found_u(steps, n), found_du(steps, n);
    for (std::ptrdiff_t k = 0; k < n; ++k) {
      found_u.col(k) = found.col(k * 2 * q + i);
      found_du.col(k) = found.col(k * 2 * q + q + i);
    }
    CHECK(u.cwiseAbs().maxCoeff() > 1e-4);
    CHECK((found_u - u).cwiseAbs().maxCoeff() < 1e-11 * u.cwiseAbs().maxCoeff());
    CHECK((found_du - du).cwiseAbs().maxCoeff() < 1e-8 * du.cwiseAbs().maxCoeff());  // of the difference, h^4
  }
}

TEST_CASE("residuals that are not computed are below the tolerance all the same") {
  const Chain chain(40);
  std::srand(6);
  const RowMatrix patterns = RowMatrix::Random(chain.K.rows(), 9);
  const RowMatrix exact = swept(chain, patterns, 50), loose = swept(chain, patterns, 50, 1e-5);
  // A residual of 1e-5 of the force each step; the chain's condition number is some 10.
  CHECK((loose - exact).cwiseAbs().maxCoeff() < 1e-4 * exact.cwiseAbs().maxCoeff());
  const RowMatrix fine = swept(chain, patterns, 50, 1e-10);
  CHECK((fine - exact).cwiseAbs().maxCoeff() < 1e-9 * exact.cwiseAbs().maxCoeff());
}

TEST_CASE("one plan of the factor serves other values, of blocks that were zero too") {
  Chain chain(12);
  const FactorPlan plan = sweep_plan(chain.pattern, chain.supports);
  std::srand(7);
  const RowMatrix patterns = RowMatrix::Random(chain.K.rows(), 2);
  for (const double scale : {1.0, 3.0}) {
    CAPTURE(scale);
    for (double& value : chain.K.values()) value *= scale;
    const RowMatrix own = swept(chain, patterns, 20), planned = swept(chain, patterns, 20, 1e-13, &plan);
    CHECK(own.cwiseAbs().maxCoeff() > 1e-4);
    CHECK((planned - own).cwiseAbs().maxCoeff() < 1e-11 * own.cwiseAbs().maxCoeff());
  }
  for (const auto& [r, c] : {std::pair{5, 6}, {6, 5}})  // a plan of these values would drop the block
    for (BlockMatrix* A : {&chain.K, &chain.C})
      std::fill_n(A->block(static_cast<std::ptrdiff_t>(chain.entry(r, c))), 9, 0.0);
  const RowMatrix own = swept(chain, patterns, 20), planned = swept(chain, patterns, 20, 1e-13, &plan);
  CHECK((planned - own).cwiseAbs().maxCoeff() < 1e-11 * own.cwiseAbs().maxCoeff());
}

TEST_CASE("threads do not change a bit of the sweep") {
  const Chain chain(40);
  std::srand(5);
  const RowMatrix patterns = RowMatrix::Random(chain.K.rows(), 9);
  const RowMatrix alone = swept(chain, patterns, 5);
  set_threads(3);
  const RowMatrix together = swept(chain, patterns, 5);
  set_threads(1);
  CHECK(alone == together);
}

TEST_CASE("a matrix without its zero blocks is the same matrix") {
  const Chain chain(9);
  const BlockMatrix short_one = without_zero_blocks(chain.dK);
  CHECK(short_one.pattern()->entries() < chain.pattern->entries());
  CHECK(Eigen::MatrixXd(short_one.to_sparse()) == Eigen::MatrixXd(chain.dK.to_sparse()));
}

TEST_CASE("what does not fit is refused") {
  const Chain chain(4);
  const auto refusal = [&](const RowMatrix& patterns, std::ptrdiff_t steps) {
    try {
      swept(chain, patterns, steps);
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(refusal(RowMatrix::Ones(9, 1), 1) ==
        "impulse_responses: rows of patterns = 9; must be the number of unknowns, 12.");
  CHECK(refusal(RowMatrix::Ones(12, 1), 0) == "impulse_responses: steps = 0; must be >= 1.");
  CHECK(refusal(RowMatrix::Constant(12, 1, std::nan("")), 1) == "impulse_responses: patterns must be finite.");
}

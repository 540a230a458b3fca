// Block-Toeplitz products against the whole matrix.
#include <doctest/doctest.h>

#include "plica/core/threads.hpp"
#include "plica/estimation/toeplitz.hpp"

using namespace plica;
using namespace plica::estimation;
using Lags = BlockToeplitz::Lags;

namespace {

BlockToeplitz random_toeplitz(std::ptrdiff_t blocks, std::ptrdiff_t rows, std::ptrdiff_t columns) {
  return {Lags::Random(blocks * rows, columns), blocks};
}

Lags whole(const BlockToeplitz& T) {
  Lags all = Lags::Zero(T.blocks * T.rows(), T.blocks * T.columns());
  for (std::ptrdiff_t k = 0; k < T.blocks; ++k)
    for (std::ptrdiff_t i = 0; i <= k; ++i)
      all.block(k * T.rows(), i * T.columns(), T.rows(), T.columns()) = T.lag(k - i);
  return all;
}

double relative(const Lags& a, const Lags& b) { return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff(); }

}  // namespace

TEST_CASE("the weighted Gram matrix is that of the whole matrices, whatever is missing") {
  std::srand(1);
  const BlockToeplitz A = random_toeplitz(19, 5, 3), B = random_toeplitz(19, 5, 2);
  Lags weights = (1.5 + Lags::Random(1, 5).array()).matrix().replicate(19, 1);
  const auto check = [&] {
    const Eigen::Map<const Vector> w(weights.data(), weights.size());
    const Lags expected = whole(A).transpose() * w.asDiagonal() * whole(B);
    CHECK(relative(toeplitz_gram(A, B, weights), expected) < 1e-13);
  };
  check();
  weights.row(0).setZero();
  weights.row(7).setZero();
  weights(18, 2) = 0;
  check();
  weights.col(4) = (1.5 + Lags::Random(19, 1).array()).matrix();
  check();
  weights.setZero();
  CHECK(toeplitz_gram(A, B, weights).isZero(0));
}

TEST_CASE("products with the matrix and its transpose are those of the whole matrix") {
  std::srand(2);
  const BlockToeplitz T = random_toeplitz(13, 4, 3);
  const Lags x = Lags::Random(13 * 3, 2), y = Lags::Random(13 * 4, 2);
  CHECK(relative(toeplitz_product(T, x), whole(T) * x) < 1e-14);
  CHECK(relative(toeplitz_transposed_product(T, y), whole(T).transpose() * y) < 1e-14);
}

TEST_CASE("threads do not change a bit") {
  std::srand(3);
  const BlockToeplitz T = random_toeplitz(40, 6, 3);
  Lags weights = Lags::Ones(40, 6);
  weights(3, 3) = 0;
  const Lags alone = toeplitz_gram(T, T, weights);
  set_threads(3);
  const Lags together = toeplitz_gram(T, T, weights);
  set_threads(1);
  CHECK(alone == together);
}

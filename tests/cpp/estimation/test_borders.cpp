#include "../borders.hpp"
#include "plica/estimation/covariance.hpp"
#include "plica/estimation/toeplitz.hpp"

using namespace plica;
using namespace plica::estimation;
using borders::sizes;

namespace {

MatrixView in(const DenseMatrix& m) { return {m.data(), m.rows(), m.cols(), m.outerStride(), 1}; }
MatrixSpan out(DenseMatrix& m) { return {m.data(), m.rows(), m.cols(), m.outerStride(), 1}; }

}  // namespace

TEST_CASE("products of covariances refuse matrices that do not fit") {
  DenseMatrix a = DenseMatrix::Random(5, 3), b = DenseMatrix::Random(3, 4), c = DenseMatrix::Zero(5, 4);
  const auto product = [&] { multiply(1.0, in(a), in(b), out(c), Part::full, Into::overwrite); };
  sizes("multiply a", a, product);
  sizes("multiply b", b, product);
  sizes("multiply c", c, product);

  DenseMatrix p = DenseMatrix::Identity(3, 3), s = DenseMatrix::Zero(5, 5), w = DenseMatrix::Random(5, 3);
  const auto sandwich = [&] { congruence(in(w), in(p), out(s), Into::overwrite); };
  sizes("congruence g", w, sandwich);
  sizes("congruence p", p, sandwich);
  sizes("congruence c", s, sandwich);

  DenseMatrix t = a.transpose();
  const auto symmetric = [&] { symmetric_product(in(a), in(t), out(s), Into::overwrite); };
  sizes("symmetric_product a", a, symmetric);
  sizes("symmetric_product b", t, symmetric);
  sizes("symmetric_product c", s, symmetric);
  sizes("gram_update p", p, [&] { gram_update(1.0, in(w), out(p)); });
  sizes("mirror_upper a", s, [&] { mirror_upper(out(s)); });
}

TEST_CASE("factors and triangular solves refuse matrices that do not fit, small and in blocks") {
  for (const std::ptrdiff_t n : {3, 100}) {
    CAPTURE(n);
    DenseMatrix r = 2 * DenseMatrix::Identity(n, n), x = DenseMatrix::Random(n, 4);
    sizes("cholesky a", r, [&] { cholesky(out(r)); });
    r = 2 * DenseMatrix::Identity(n, n);
    for (const auto solve : {solve_lower, solve_upper}) {
      const auto call = [&] { solve(in(r), out(x)); };
      sizes("solve r", r, call);
      sizes("solve x", x, call);
    }
  }
}

TEST_CASE("block-Toeplitz products refuse what is not of their blocks") {
  BlockToeplitz T{BlockToeplitz::Lags::Random(4 * 3, 2), 4}, B = T;
  BlockToeplitz::Lags x = BlockToeplitz::Lags::Random(4 * 2, 3), y = BlockToeplitz::Lags::Random(4 * 3, 3),
                      weights = BlockToeplitz::Lags::Ones(4, 3);
  const auto product = [&] { toeplitz_product(T, x); };
  const auto transposed = [&] { toeplitz_transposed_product(T, y); };
  const auto gram = [&] { toeplitz_gram(T, B, weights); };
  sizes("toeplitz_product x", x, product);
  sizes("toeplitz_transposed_product x", y, transposed);
  sizes("toeplitz_gram weights", weights, gram);
  for (const std::function<void()>& call :
       {std::function<void()>(product), std::function<void()>(transposed), std::function<void()>(gram)}) {
    borders::numbers<std::ptrdiff_t>("blocks", T.blocks, {0, -1, 5, 100}, call);
    T.lags = BlockToeplitz::Lags::Ones(11, 2);
    CHECK_THROWS_AS(call(), InvalidInput);
    T.lags = B.lags;
  }
}

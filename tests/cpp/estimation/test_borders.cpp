#include "../borders.hpp"
#include "../solve/lattice.hpp"
#include "plica/estimation/covariance.hpp"
#include "plica/estimation/sweep.hpp"
#include "plica/estimation/toeplitz.hpp"

using namespace plica;
using namespace plica::estimation;
using borders::indices;
using borders::numbers;
using borders::refused;
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
  DenseMatrix wide = w.transpose();  // one column fewer of W
  refused("gram_update w", [&] { gram_update(1.0, in(wide), out(p)); });
  sizes("mirror_upper a", s, [&] { mirror_upper(out(s)); });
}

TEST_CASE("factors and triangular solves refuse matrices that do not fit, small and in blocks") {
  for (const std::ptrdiff_t n : {3, 100}) {
    CAPTURE(n);
    DenseMatrix r = 2 * DenseMatrix::Identity(n, n), x = DenseMatrix::Random(n, 4);
    sizes("cholesky a", r, [&] { cholesky(out(r)); });
    r = 2 * DenseMatrix::Identity(n, n);
    sizes("solve_lower r", r, [&] { solve_lower(in(r), out(x)); });
    sizes("solve_lower x", x, [&] { solve_lower(in(r), out(x)); });
    sizes("solve_upper r", r, [&] { solve_upper(in(r), out(x)); });
    sizes("solve_upper x", x, [&] { solve_upper(in(r), out(x)); });
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
  std::ptrdiff_t l = 0;
  numbers<std::ptrdiff_t>("BlockToeplitz::lag l", l, {-1, 4}, [&] { T.lag(l); });
  refused("BlockToeplitz::lag l", [] { BlockToeplitz{BlockToeplitz::Lags(), 0}.lag(0); });
  refused("BlockToeplitz::rows", [] { BlockToeplitz{BlockToeplitz::Lags(), 0}.rows(); });
  sizes("toeplitz_gram B", B.lags, gram);
  for (const auto& [name, call] : {std::pair<const char*, std::function<void()>>{"toeplitz_product T", product},
                                   {"toeplitz_transposed_product T", transposed},
                                   {"toeplitz_gram A", gram}}) {
    numbers<std::ptrdiff_t>(name, T.blocks, {0, -1, 5, 100}, call);
    T.lags = BlockToeplitz::Lags::Ones(11, 2);
    CHECK_THROWS_AS(call(), InvalidInput);
    T.lags = B.lags;
  }
}

TEST_CASE("impulse responses refuse matrices, supports and a plan of another pattern, and unknowns not there") {
  const BlockMatrix K = plica_test::spring_lattice(2), other = plica_test::spring_lattice(3);
  NodalMatrix M(K.pattern());
  for (std::int32_t i = 0; i < 8; ++i) M.values()[static_cast<std::size_t>(K.pattern()->find(i, i))] = 1.0;
  const Supports supports(8);
  std::optional<BlockMatrix> C;
  RowMatrix patterns = RowMatrix::Random(24, 2);
  std::vector<Direction> directions{{K, K}};
  Indices observed(2);
  observed << 0, 23;
  std::ptrdiff_t steps = 2;
  const FactorPlan plan = sweep_plan(K.pattern(), supports),
                   wrong_plan = sweep_plan(other.pattern(), Supports(27));
  const FactorPlan* which = &plan;
  const LinearMotion motion{M, C, K, supports, 0.0, 0.25, 0.5, 0.1};
  const auto answer = [&] { impulse_responses(motion, patterns, directions, observed, steps, 1e-10, which); };
  sizes("impulse_responses patterns", patterns, answer);
  indices("impulse_responses observed", observed, answer);
  numbers<std::ptrdiff_t>("impulse_responses steps", steps, {0, -1}, answer);
  which = &wrong_plan;
  refused("impulse_responses plan", answer);
  which = nullptr;
  C = other;
  refused("impulse_responses motion.C", answer);
  C.reset();
  for (const Direction& wrong : {Direction{other, {}}, Direction{{}, other}}) {
    directions = {wrong};
    refused("impulse_responses directions", answer);
  }
  directions.clear();
  answer();
  const NodalMatrix other_mass(other.pattern());
  const Supports other_supports(27);
  const auto of = [&](const NodalMatrix& mass, const Supports& held) {
    impulse_responses({mass, C, K, held, 0.0, 0.25, 0.5, 0.1}, patterns, {}, observed, steps, 1e-10);
  };
  refused("impulse_responses motion.M", [&] { of(other_mass, supports); });
  refused("impulse_responses motion.supports", [&] { of(M, other_supports); });
  refused("sweep_plan supports", [&] { sweep_plan(K.pattern(), other_supports); });
  refused("sweep_plan pattern", [&] { sweep_plan(nullptr, supports); });
}

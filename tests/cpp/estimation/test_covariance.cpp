#include <doctest/doctest.h>

#include <cstdlib>
#include <limits>

#include "plica/core/threads.hpp"
#include "plica/estimation/covariance.hpp"

using namespace plica;
using namespace plica::estimation;

namespace {

/// Entries of the size of 1, the same each time.
DenseMatrix random_matrix(std::ptrdiff_t rows, std::ptrdiff_t columns, unsigned seed) {
  std::srand(seed);
  return DenseMatrix::Random(rows, columns);
}

DenseMatrix random_covariance(std::ptrdiff_t n, unsigned seed) {
  const DenseMatrix a = random_matrix(n, n, seed);
  return a * a.transpose() + DenseMatrix::Identity(n, n);
}

double difference(const DenseMatrix& a, const DenseMatrix& b) {
  REQUIRE(a.rows() == b.rows());
  REQUIRE(a.cols() == b.cols());
  return a.size() == 0 ? 0.0 : (a - b).cwiseAbs().maxCoeff();
}

// Sizes around the tiles (4, 6, 12 rows; 4, 8, 16 columns), the row blocks (48), the depth (256) and the bases of
// the recursions (32, 48).
const std::ptrdiff_t orders[] = {0, 1, 3, 12, 16, 17, 31, 33, 48, 49, 97, 150, 300};

/// Round-off of sums of `terms` products of the size of 1.
double round_off(std::ptrdiff_t terms) { return 1e-15 * static_cast<double>(terms + 1); }

}  // namespace

TEST_CASE("a product is Eigen's, for any sizes and storage") {
  for (std::ptrdiff_t m : {0, 1, 5, 12, 49}) {
    for (std::ptrdiff_t k : {0, 1, 7, 256, 600}) {
      for (std::ptrdiff_t n : {0, 1, 4, 16, 33, 130}) {
        const DenseMatrix a = random_matrix(m, k, 1), b = random_matrix(k, n, 2), start = random_matrix(m, n, 3);
        DenseMatrix c = start;
        multiply(1.0, view(a), view(b), span(c), Part::full, Into::overwrite);
        CHECK(difference(c, a * b) <= round_off(k));
        c = start;
        multiply(-0.5, view(a), view(b), span(c), Part::full, Into::add);
        CHECK(difference(c, start - 0.5 * a * b) <= round_off(k));
        const DenseMatrix at = a.transpose(), bt = b.transpose();
        multiply(1.0, view(at).transposed(), view(bt).transposed(), span(c), Part::full, Into::overwrite);
        CHECK(difference(c, a * b) <= round_off(k));
      }
    }
  }
}

TEST_CASE("a product writes its block alone") {
  DenseMatrix all = DenseMatrix::Constant(40, 50, 7.0);
  const DenseMatrix a = random_matrix(23, 31, 1), b = random_matrix(31, 29, 2);
  multiply(1.0, view(a), view(b), span(all).block(5, 9, 23, 29), Part::full, Into::overwrite);
  DenseMatrix expected = DenseMatrix::Constant(40, 50, 7.0);
  expected.block(5, 9, 23, 29) = a * b;
  CHECK(difference(all, expected) <= round_off(31));
}

TEST_CASE("covariance products are symmetric to the bit and Eigen's") {
  for (std::ptrdiff_t n : orders) {
    const std::ptrdiff_t m = (2 * n + 2) / 3;
    const DenseMatrix g = random_matrix(m, n, 4), p = random_covariance(n, 5), q = random_covariance(m, 6);
    DenseMatrix c = q;
    congruence(view(g), view(p), span(c), Into::add);
    const double scale = static_cast<double>(n + 1);
    CHECK(difference(c, q + g * p * g.transpose()) <= 10 * scale * round_off(n));
    CHECK(difference(c, c.transpose()) == 0.0);

    DenseMatrix updated = p;
    gram_update(-0.25, view(g), span(updated));
    CHECK(difference(updated, p - 0.25 * g.transpose() * g) <= scale * round_off(m));
    CHECK(difference(updated, updated.transpose()) == 0.0);

    DenseMatrix square(m, m);
    symmetric_product(view(g), view(g).transposed(), span(square), Into::overwrite);
    CHECK(difference(square, g * g.transpose()) <= round_off(n));
    CHECK(difference(square, square.transpose()) == 0.0);
  }
}

TEST_CASE("factor and solves undo the product") {
  for (std::ptrdiff_t n : orders) {
    const DenseMatrix p = random_covariance(n, 7);
    DenseMatrix r = p;
    REQUIRE(cholesky(span(r)) == n);
    const double scale = static_cast<double>(n + 1);
    CHECK(difference(r.transpose() * r, p) <= 10 * scale * round_off(n));
    CHECK(DenseMatrix(r.triangularView<Eigen::StrictlyLower>()).cwiseAbs().sum() == 0.0);
    for (std::ptrdiff_t columns : {1, 16, 64, 65, 200}) {
      const DenseMatrix x = random_matrix(n, columns, 8);
      DenseMatrix y = r.transpose() * x;
      solve_lower(view(r), span(y));
      // The factor's smallest pivot is at least 1, its condition at most the largest, of the size of n.
      CHECK(difference(y, x) <= 10 * scale * round_off(n));
      y = r * x;
      solve_upper(view(r), span(y));
      CHECK(difference(y, x) <= 10 * scale * round_off(n));
    }
  }
}

TEST_CASE("a matrix that is not positive definite stops the factor in the row that shows it") {
  for (std::ptrdiff_t n : {5, 40, 100}) {
    for (std::ptrdiff_t row : {std::ptrdiff_t{0}, n / 2, n - 1}) {
      DenseMatrix p = random_covariance(n, 9);
      p(row, row) = -1.0;
      CHECK(cholesky(span(p)) == row);
      p = random_covariance(n, 9);
      p(row, row) = std::numeric_limits<double>::quiet_NaN();
      CHECK(cholesky(span(p)) == row);
    }
  }
}

TEST_CASE("the number of threads changes no bit") {
  const std::ptrdiff_t n = 310;
  const DenseMatrix g = random_matrix(n, n, 10), p = random_covariance(n, 11);
  const auto all = [&] {
    DenseMatrix c(n, n), r = p, x = g;
    congruence(view(g), view(p), span(c), Into::overwrite);
    REQUIRE(cholesky(span(r)) == n);
    solve_lower(view(r), span(x));
    solve_upper(view(r), span(x));
    return DenseMatrix(c + r + x);
  };
  const DenseMatrix one = all();
  for (int threads : {2, 3, 5}) {
    set_threads(threads);
    CHECK(difference(all(), one) == 0.0);
  }
  set_threads(1);
}

#include <doctest/doctest.h>

#include <cmath>

#include "../approx.hpp"
#include "plica/core/eigenpairs.hpp"

using namespace plica;

TEST_CASE("eigenpairs diagonalise the matrix whose lower triangle is given, in ascending order") {
  // The Laplacian of a row of n points between two that are held: 2 - 2 cos(k pi / (n + 1)), k = 1 ... n.
  constexpr int n = 12;
  const double pi = std::acos(-1.0);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  A.diagonal().setConstant(2.0);
  A.diagonal(-1).setConstant(-1.0);
  A.triangularView<Eigen::StrictlyUpper>().setConstant(7.0);  // not read

  const auto [values, vectors] = symmetric_eigenpairs(A);
  for (int k = 1; k <= n; ++k) CHECK(values[k - 1] == approx(2 - 2 * std::cos(k * pi / (n + 1))).epsilon(1e-13));
  CHECK((vectors.transpose() * vectors - Eigen::MatrixXd::Identity(n, n)).norm() < 1e-13);
  const Eigen::MatrixXd whole = A.selfadjointView<Eigen::Lower>();
  CHECK((whole * vectors - vectors * values.asDiagonal()).norm() < 1e-13);
}

#include <doctest/doctest.h>

#include <limits>
#include <utility>

#include "lattice.hpp"
#include "plica/core/error.hpp"
#include "plica/solve/factorization.hpp"
#include "plica/solve/krylov.hpp"

using namespace plica;
using plica_test::random_vector;
using plica_test::spring_lattice;

TEST_CASE("a factorisation solves to rounding and agrees with conjugate gradients") {
  const BlockMatrix A = spring_lattice(6);
  const Vector b = random_vector(A.rows());
  const Factorization factor(A.to_sparse());
  const Vector x = factor.solve(b);
  CHECK((A * x - b).norm() < 1e-13 * b.norm());  // backward stable: some n^(1/2) rounding errors
  Vector iterated;
  ConjugateGradient(A, {1e-12, 1000}).solve(b, iterated);
  CHECK((x - iterated).norm() < 1e-9 * x.norm());  // condition number, some 1e3, times the tolerance
}

TEST_CASE("a moved factorisation still solves") {
  const BlockMatrix A = spring_lattice(3);
  Factorization first(A.to_sparse());
  const Vector b = random_vector(A.rows());
  const Vector x = first.solve(b);
  const Factorization second = std::move(first);
  CHECK(second.solve(b) == x);
}

TEST_CASE("a body without support and an indefinite matrix are refused") {
  BlockMatrix A = spring_lattice(4, 0.0);              // no ground springs: moves freely
  CHECK((A * Vector::Ones(A.rows())).norm() < 1e-12);  // rounding: 26 springs a node
  CHECK_THROWS_WITH_AS(Factorization(A.to_sparse()), doctest::Contains("not positive definite"), SolveFailed);
  BlockMatrix B = spring_lattice(4, 0.05);
  B.block(B.pattern()->find(20, 20))[0] -= 100.0;
  CHECK_THROWS_WITH_AS(Factorization(B.to_sparse()), doctest::Contains("not positive definite"), SolveFailed);
}

TEST_CASE("a weakly held body is accepted") {
  const BlockMatrix A = spring_lattice(4, 1e-7);
  const Vector x = Factorization(A.to_sparse()).solve(Vector::Ones(A.rows()));
  // The ground springs alone carry a uniform load: 1 / 1e-7 each, to a condition number of 1e8 rounding errors.
  CHECK((x * 1e-7 - Vector::Ones(A.rows())).cwiseAbs().maxCoeff() < 1e-6);
}

TEST_CASE("pivots are judged by their own unknown's diagonal, whatever the units") {
  // S A S with scales from 1 to 1e10: as well conditioned as A for a Cholesky factorisation.
  const BlockMatrix A = spring_lattice(4);
  const Vector scale = Eigen::pow(10.0, 5.0 * (random_vector(A.rows(), 12).array() + 1.0));
  const SparseMatrix scaled = SparseMatrix(scale.asDiagonal() * A.to_sparse()) * scale.asDiagonal();
  const Vector b = random_vector(A.rows());
  const Vector x = Factorization(scaled).solve(scale.cwiseProduct(b)).cwiseProduct(scale);
  CHECK((A * x - b).norm() < 1e-12 * b.norm());  // rounding times a condition number of A below 1e3
}

TEST_CASE("wrong sizes and numbers that are not finite are refused") {
  const BlockMatrix A = spring_lattice(2);
  CHECK_THROWS_AS(Factorization(A.to_sparse()).solve(Vector::Ones(5)), InvalidInput);
  CHECK_THROWS_AS(Factorization(SparseMatrix(3, 4)), InvalidInput);
  SparseMatrix bad = A.to_sparse();
  bad.valuePtr()[2] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH_AS(Factorization{bad}, "Factorization: A(0, 2) = nan; must be finite.", InvalidInput);
}

#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <limits>

#include "lattice.hpp"
#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "plica/solve/krylov.hpp"

using namespace plica;
using plica_test::random_vector;
using plica_test::spring_lattice;

TEST_CASE("conjugate gradients solve to the tolerance asked for") {
  const BlockMatrix A = spring_lattice(5);
  const Vector b = random_vector(A.rows());
  for (double tolerance : {1e-3, 1e-6, 1e-10}) {
    Vector x;
    const Convergence end = ConjugateGradient(A, {tolerance, 500}).solve(b, x);
    CHECK(end.converged);
    CHECK(end.iterations > 1);
    CHECK(end.residual <= tolerance);
    // The recursion's residual and the true one differ by rounding, some 1e-15 here.
    CHECK((b - A * x).norm() / b.norm() == doctest::Approx(end.residual).epsilon(1e-3));
  }
}

TEST_CASE("conjugate gradients equal a dense Cholesky solution") {
  const BlockMatrix A = spring_lattice(4);
  const Vector b = random_vector(A.rows());
  const Vector reference = Eigen::MatrixXd(A.to_sparse()).llt().solve(b);
  Vector x;
  ConjugateGradient(A, {1e-12, 500}).solve(b, x);
  // Error <= condition number (some 1e3) times the tolerance.
  CHECK((x - reference).norm() < 1e-9 * reference.norm());
}

TEST_CASE("conjugate gradients give the same bits on one and on three threads") {
  const BlockMatrix A = spring_lattice(10);  // 1000 nodes: four chunks
  const Vector b = random_vector(A.rows());
  const ConjugateGradient solver(A, {1e-8, 500});
  Vector one, three;
  set_threads(1);
  const int iterations = solver.solve(b, one).iterations;
  set_threads(3);
  CHECK(solver.solve(b, three).iterations == iterations);
  set_threads(1);
  CHECK((one.array() == three.array()).all());
}

TEST_CASE("a start at the solution takes no iteration and a near start fewer") {
  const BlockMatrix A = spring_lattice(5);
  const Vector b = random_vector(A.rows());
  const ConjugateGradient solver(A, {1e-8, 500});
  Vector x;
  const int cold = solver.solve(b, x).iterations;
  ConjugateGradient(A, {1e-12, 500}).solve(b, x);
  CHECK(solver.solve(b, x).iterations == 0);
  x *= 1.0 + 1e-5;
  const int warm = solver.solve(b, x).iterations;
  CHECK(warm > 0);
  CHECK(warm < cold);
}

TEST_CASE("a zero load gives zero whatever the start") {
  const BlockMatrix A = spring_lattice(3);
  Vector x = random_vector(A.rows());
  const Convergence end = ConjugateGradient(A, {}).solve(Vector::Zero(A.rows()), x);
  CHECK(end.converged);
  CHECK(x == Vector::Zero(A.rows()));
}

TEST_CASE("running out of iterations is data, not an exception") {
  const BlockMatrix A = spring_lattice(5);
  Vector x;
  const Convergence end = ConjugateGradient(A, {1e-10, 3}).solve(random_vector(A.rows()), x);
  CHECK_FALSE(end.converged);
  CHECK(end.iterations == 3);
  CHECK(end.residual > 1e-10);
}

TEST_CASE("block-Jacobi applies the inverse of the diagonal blocks") {
  const BlockMatrix A = spring_lattice(3);
  const Vector r = random_vector(A.rows());
  Vector z;
  ConjugateGradient(A, {}).precondition(r, z);
  const Eigen::MatrixXd dense = A.to_sparse();
  for (int i = 0; i < A.rows(); i += 3) {
    // Rounding of a 3x3 solve of condition number below 10.
    CHECK((dense.block<3, 3>(i, i) * z.segment<3>(i) - r.segment<3>(i)).norm() < 1e-14);
  }
}

TEST_CASE("each of many right-hand sides gets the bits it gets in other company") {
  const BlockMatrix A = spring_lattice(7);  // 343 nodes: two chunks
  const int count = 11;                     // two packs, the second not full
  Eigen::MatrixXd B(A.rows(), count);
  for (int c = 0; c < count; ++c) B.col(c) = random_vector(A.rows(), 20 + c) * std::pow(10.0, c - 5);
  B.col(4).setZero();
  B.col(6) = A * random_vector(A.rows(), 3);
  B.col(7) = A * Vector::Ones(A.rows());  // converges at another iteration than the noise
  const ConjugateGradient solver(A, {1e-8, 500});
  Eigen::MatrixXd X;
  set_threads(2);
  const auto ends = solver.solve_many(B, X);
  set_threads(1);
  bool different_lengths = false;
  for (int c = 0; c < count; ++c) {
    CAPTURE(c);
    CHECK(ends[c].converged);
    different_lengths = different_lengths || ends[c].iterations != ends[0].iterations;
    Eigen::MatrixXd alone;
    const auto end = solver.solve_many(B.col(c), alone);
    CHECK(end[0].iterations == ends[c].iterations);
    CHECK((alone.col(0).array() == X.col(c).array()).all());
    const Vector b = B.col(c), x = X.col(c);
    CHECK((b - A * x).norm() <= 1.01e-8 * b.norm());  // 1 %: rounding of the recursion
  }
  CHECK(different_lengths);
  CHECK(ends[4].iterations == 0);
}

TEST_CASE("a matrix that is not positive definite is refused") {
  BlockMatrix A = spring_lattice(3);
  Vector x;
  const Vector b = random_vector(A.rows());
  BlockMatrix bad_block = A;
  bad_block.block(bad_block.pattern()->find(5, 5))[4] = -1.0;
  CHECK_THROWS_WITH_AS(ConjugateGradient(bad_block, {}), doctest::Contains("diagonal block of node 5"),
                       SolveFailed);

  // Positive blocks on the diagonal, a strong coupling beside it.
  const NodePattern& p = *A.pattern();
  for (int k = 0; k < 3; ++k) {
    A.block(p.find(0, 1))[4 * k] -= 100.0;
    A.block(p.find(1, 0))[4 * k] -= 100.0;
  }
  const ConjugateGradient solver(A, {});
  CHECK_THROWS_WITH_AS(solver.solve(b, x), doctest::Contains("not positive definite: p^T A p = -"), SolveFailed);
  Eigen::MatrixXd X;
  CHECK_THROWS_WITH_AS(solver.solve_many(b, X), doctest::Contains("right-hand side 0"), SolveFailed);
}

TEST_CASE("numbers that are not finite are refused") {
  const BlockMatrix A = spring_lattice(3);
  const ConjugateGradient solver(A, {});
  Vector b = random_vector(A.rows()), x;
  b[4] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH_AS(solver.solve(b, x), doctest::Contains("must be finite"), SolveFailed);
  Eigen::MatrixXd X;
  CHECK_THROWS_AS(solver.solve_many(b, X), SolveFailed);
  Vector start = b;
  CHECK_THROWS_WITH_AS(solver.solve(Vector::Ones(A.rows()), start), doctest::Contains("must be finite"),
                       SolveFailed);
}

TEST_CASE("wrong sizes and options are refused") {
  const BlockMatrix A = spring_lattice(2);
  Vector x;
  CHECK_THROWS_AS(ConjugateGradient(A, {}).solve(Vector::Ones(5), x), InvalidInput);
  CHECK_THROWS_WITH_AS((KrylovOptions{1.0, 10}.validate()), "KrylovOptions: tolerance = 1; must be in (0, 1).",
                       InvalidInput);
  CHECK_THROWS_AS((KrylovOptions{1e-8, 0}.validate()), InvalidInput);
}

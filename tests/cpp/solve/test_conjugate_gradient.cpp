#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <limits>

#include "../approx.hpp"
#include "lattice.hpp"
#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "plica/mesh/block.hpp"
#include "plica/solve/factorization.hpp"
#include "plica/solve/krylov.hpp"
#include "plica/solve/supports.hpp"
#include "plica/tissue/assembly.hpp"

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
    CHECK((b - A * x).norm() / b.norm() == approx(end.residual).epsilon(1e-3));
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

TEST_CASE("a matrix too badly conditioned for single precision is solved as the factorisation solves it") {
  // Weak ground springs: the body almost floats, and the condition number is about 25 / ground. Rounded to single
  // precision the matrix is off by some 1e-6, so it is wrong about the floating modes or not positive definite.
  for (const double ground : {1e-6, 2.5e-8}) {
    CAPTURE(ground);
    const BlockMatrix A = spring_lattice(6, ground);
    // A load that moves the body by some 1e3 spring lengths: the residual can be had to 1e-16 times that and the
    // stiffness, below the tolerance.
    const Vector b = random_vector(A.rows()) * 1e-3 + A * Vector::Constant(A.rows(), 1e3);
    Vector x;
    const Convergence end = ConjugateGradient(A, {1e-8, 2000}).solve(b, x);
    CHECK(end.converged);
    CHECK((b - A * x).norm() <= 1e-8 * b.norm());
    const Vector direct = Factorization(A.to_sparse()).solve(b);
    // The load is a sum over rows of cancelling terms, so that its round-off is felt in both solutions alike.
    CHECK((x - direct).norm() <= 1e-6 * direct.norm());
  }
}

TEST_CASE("a hardly compressible block and a step a hundred times longer converge too") {
  for (const double nu : {0.45, 0.499})
    for (const double step : {50e-6, 5e-3}) {
      CAPTURE(nu);
      CAPTURE(step);
      const TetMesh mesh = block_mesh({{0, 0, 0}, {0.02, 0.01, 0.01}, {8, 4, 4}});
      const Tissue tissue{{{Isotropic{20e3, nu}, 1040.0, 0.0}}, {"body"}, Indices::Zero(mesh.cell_count())};
      const Assembler assembler(mesh);
      BlockMatrix A = assembler.stiffness(tissue);
      for (double& value : A.values()) value *= 0.25 * step * step;
      const NodalMatrix M = assembler.mass(tissue);
      for (std::size_t e = 0; e < M.values().size(); ++e)
        for (int d = 0; d < 3; ++d) A.values()[9 * e + 4 * d] += M.values()[e];
      Supports supports(mesh.node_count());
      for (const auto node : mesh.node_set("x_min")) supports.fix(node);
      supports.constrain(A);
      Vector b = random_vector(A.rows());
      supports.project(b);
      Vector x;
      const Convergence end = ConjugateGradient(A, {1e-8, 2000}).solve(b, x);
      CHECK(end.converged);
      CHECK((b - A * x).norm() <= 1e-8 * b.norm());
    }
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

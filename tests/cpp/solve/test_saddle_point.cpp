#include <doctest/doctest.h>

#include <Eigen/LU>

#include "../approx.hpp"
#include "lattice.hpp"
#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "plica/solve/saddle_point.hpp"

using namespace plica;
using plica_test::random_vector;

namespace {

constexpr int side = 6;

/// Rows that tie one node to the mean of two others along a random direction; their gaps see a second direction,
/// `bend` of it across the first.
std::vector<SaddleRow> constraints(int count, double bend) {
  std::vector<SaddleRow> rows;
  const Vector random = random_vector(7 * count, 3);
  for (int i = 0; i < count; ++i) {
    const Vector3 normal = random.segment<3>(7 * i).normalized();
    Vector3 across = random.segment<3>(7 * i + 3);
    across -= normal.dot(across) * normal;
    const Vector3 gradient = normal + bend * across.normalized();
    const std::int32_t slave = 11 * i, first = 11 * i + 4, second = 11 * i + 7;
    rows.push_back({{{slave, normal}, {first, -0.3 * normal}, {second, -0.7 * normal}},
                    {{slave, gradient}, {first, -0.3 * gradient}, {second, -0.7 * gradient}},
                    0.0,
                    random[7 * i + 6]});
  }
  return rows;
}

/// The whole matrix, without the regularisation.
Eigen::MatrixXd dense(const BlockMatrix& A, const std::vector<SaddleRow>& rows) {
  const std::ptrdiff_t n = A.rows(), m = static_cast<std::ptrdiff_t>(rows.size());
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n + m, n + m);
  M.topLeftCorner(n, n) = A.to_sparse();
  for (std::ptrdiff_t i = 0; i < m; ++i) {
    const SaddleRow& row = rows[static_cast<std::size_t>(i)];
    for (const auto& [node, vector] : row.push) M.col(n + i).segment<3>(3 * node) += vector;
    for (const auto& [node, vector] : row.gap) M.row(n + i).segment<3>(3 * node) += vector.transpose();
    M(n + i, n + i) = -row.compliance;
  }
  return M;
}

}  // namespace

TEST_CASE("the saddle point is solved as a dense elimination solves it, with gaps along forces or bent away") {
  const BlockMatrix A = plica_test::spring_lattice(side);
  for (const double bend : {0.0, 0.3, 2.0}) {
    CAPTURE(bend);
    std::vector<SaddleRow> rows = constraints(18, bend);
    rows[3].compliance = 0.5;  // of the size of the row's own
    rows[4].compliance = 50.0;
    const Eigen::MatrixXd M = dense(A, rows);
    Vector right = Vector::Zero(M.rows());
    for (std::size_t i = 0; i < rows.size(); ++i) right[A.rows() + static_cast<std::ptrdiff_t>(i)] = rows[i].value;
    const Vector exact = M.partialPivLu().solve(right);
    Vector d = Vector::Zero(A.rows()), lambda = Vector::Zero(18);
    const SaddlePoint saddle(A, {1e-11, 2000});
    const Convergence end = saddle.solve(rows, d, lambda);
    CHECK(end.converged);
    CHECK((d - exact.head(A.rows())).norm() < 1e-8 * exact.head(A.rows()).norm());  // regularisation 1e-9
    CHECK((lambda - exact.tail(18)).norm() < 1e-8 * exact.tail(18).norm());
    CHECK(saddle.solve(rows, d, lambda).iterations == 1);  // the product that finds nothing left to do
  }
}

TEST_CASE("constraints that nearly repeat others in their forces but not in their gaps are solved for") {
  const BlockMatrix A = plica_test::spring_lattice(side);
  std::vector<SaddleRow> rows = constraints(6, 0.0), bent = constraints(6, 2.0);
  for (std::size_t i = 0; i < 6; ++i) {
    bent[i].push[0].vector *= 1.001;
    bent[i].gap[0].vector *= 0.9;
    rows.push_back(bent[i]);
  }
  const std::ptrdiff_t n = A.rows(), m = 12;
  Eigen::MatrixXd M = dense(A, rows);
  double largest = 0.0;  // diagonal entry of N B N^T: its 1e-9th is the regularisation, which matters here
  for (std::ptrdiff_t i = 0; i < m; ++i) {
    const Vector column = M.col(n + i).head(n);
    Vector z;
    ConjugateGradient(A, {}).precondition(column, z);
    largest = std::max(largest, column.dot(z));
  }
  M.bottomRightCorner(m, m).diagonal().array() -= 1e-9 * largest;
  Vector right = Vector::Zero(n + m);
  for (std::ptrdiff_t i = 0; i < m; ++i) right[n + i] = rows[static_cast<std::size_t>(i)].value;
  const Vector exact = M.partialPivLu().solve(right);
  Vector d = Vector::Zero(n), lambda = Vector::Zero(m);
  const Convergence end = SaddlePoint(A, {1e-11, 5000}).solve(rows, d, lambda);
  CHECK(end.converged);
  // The tolerance times how badly conditioned such rows are, some 1e3.
  CHECK((d - exact.head(n)).norm() < 1e-7 * exact.head(n).norm());
  CHECK((lambda - exact.tail(m)).norm() < 1e-7 * exact.tail(m).norm());
}

TEST_CASE("it takes about as many products as conjugate gradients on A") {
  const BlockMatrix A = plica_test::spring_lattice(side);
  const std::vector<SaddleRow> rows = constraints(18, 0.0);
  Vector b = Vector::Zero(A.rows()), x, d = b, lambda = Vector::Zero(18);
  for (const SaddleRow& row : rows)
    for (const auto& [node, vector] : row.push) b.segment<3>(3 * node) += row.value * vector;
  const int alone = ConjugateGradient(A, {1e-9, 2000}).solve(b, x).iterations;
  const int constrained = SaddlePoint(A, {1e-9, 2000}).solve(rows, d, lambda).iterations;
  CHECK(alone > 10);
  CHECK(constrained <= 2 * alone);
}

TEST_CASE("constraints that repeat others share their force and leave the motion as it was") {
  const BlockMatrix A = plica_test::spring_lattice(side);
  std::vector<SaddleRow> rows = constraints(6, 0.2);
  Vector d = Vector::Zero(A.rows()), lambda = Vector::Zero(6);
  const SaddlePoint saddle(A, {1e-11, 2000});
  REQUIRE(saddle.solve(rows, d, lambda).converged);
  rows.push_back(rows[2]);
  rows.push_back(rows[2]);
  Vector again = Vector::Zero(A.rows()), shared = Vector::Zero(8);
  REQUIRE(saddle.solve(rows, again, shared).converged);
  CHECK((again - d).norm() < 1e-7 * d.norm());
  for (const int k : {2, 6, 7}) CHECK(shared[k] == approx(lambda[2] / 3).epsilon(1e-6));
}

TEST_CASE("the saddle point has the same bits on one and on three threads") {
  const BlockMatrix A = plica_test::spring_lattice(9);
  const std::vector<SaddleRow> rows = constraints(18, 0.3);
  const SaddlePoint saddle(A, {1e-9, 2000});
  Vector d = Vector::Zero(A.rows()), lambda = Vector::Zero(18), d_three = d, lambda_three = lambda;
  saddle.solve(rows, d, lambda);
  set_threads(3);
  saddle.solve(rows, d_three, lambda_three);
  set_threads(1);
  CHECK(d == d_three);
  CHECK(lambda == lambda_three);
}

TEST_CASE("a saddle point out of iterations is data, one that pushes nothing an error") {
  const BlockMatrix A = plica_test::spring_lattice(side);
  std::vector<SaddleRow> rows = constraints(6, 0.3);
  Vector d = Vector::Zero(A.rows()), lambda = Vector::Zero(6);
  const Convergence end = SaddlePoint(A, {1e-9, 4}).solve(rows, d, lambda);
  CHECK_FALSE(end.converged);
  CHECK(end.residual > 1e-9);
  for (SaddleRow& row : rows)
    for (auto& [node, vector] : row.push) vector.setZero();
  d.setZero();
  lambda.setZero();
  CHECK_THROWS_WITH_AS(SaddlePoint(A, {}).solve(rows, d, lambda),
                       doctest::Contains("compliance of the closed rows is singular"), SolveFailed);
}

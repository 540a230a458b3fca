#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <limits>

#include "../approx.hpp"
#include "lattice.hpp"
#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "plica/solve/krylov.hpp"

using namespace plica;
using plica_test::random_vector;

namespace {

std::function<void(const Vector&, Vector&)> product(const Eigen::MatrixXd& M) {
  return [&M](const Vector& x, Vector& y) { y = M * x; };
}

/// [A G^T; G 0] with A definite: indefinite, as the contact system of Eq. (25) is. G has one row per
/// constraint, each tying the difference of two unknowns.
struct SaddleSystem {
  Eigen::MatrixXd M;
  Vector diagonal;  // Eq. (29): diag A, and diag(G diag(A)^-1 G^T)
  explicit SaddleSystem(int constraints) {
    const Eigen::MatrixXd A = plica_test::spring_lattice(3, 1.0).to_sparse();
    const Eigen::Index n = A.rows(), total = n + constraints;
    M = Eigen::MatrixXd::Zero(total, total);
    M.topLeftCorner(n, n) = A;
    for (int c = 0; c < constraints; ++c) {
      M(n + c, 7 * c) = M(7 * c, n + c) = 1.0;
      M(n + c, 7 * c + 3) = M(7 * c + 3, n + c) = -1.0;
    }
    diagonal = M.diagonal();
    for (Eigen::Index c = n; c < total; ++c) {
      diagonal[c] = (M.col(c).head(n).array().square() / A.diagonal().array()).sum();
    }
  }
};

}  // namespace

TEST_CASE("gmres solves an indefinite saddle point like a dense elimination, restarted or not") {
  const SaddleSystem s(6);
  const Vector b = random_vector(s.M.rows());
  const Vector reference = s.M.partialPivLu().solve(b);
  CHECK(s.M.topLeftCorner(81, 81).ldlt().isPositive());
  CHECK_FALSE(s.M.ldlt().isPositive());
  for (int restart : {200, 20}) {
    CAPTURE(restart);
    Vector x;
    const Convergence end = gmres(product(s.M), s.diagonal, b, x, {1e-12, 2000}, restart);
    CHECK(end.converged);
    CHECK((x - reference).norm() < 1e-9 * reference.norm());  // condition number below 1e3 times the tolerance
  }
}

TEST_CASE("the residual of gmres is that of the scaled system") {
  const SaddleSystem s(6);
  const Vector b = random_vector(s.M.rows());
  const Vector scale = s.diagonal.cwiseSqrt().cwiseInverse();
  Vector x;
  const Convergence end = gmres(product(s.M), s.diagonal, b, x, {1e-5, 2000}, 200);
  const double residual = scale.cwiseProduct(b - s.M * x).norm() / scale.cwiseProduct(b).norm();
  CHECK(end.residual <= 1e-5);
  CHECK(end.residual == approx(residual).epsilon(1e-8));  // 1e-5 of rounding 1e-16, with margin
}

TEST_CASE("gmres ends with the exact solution when the Krylov space is complete") {
  // Two distinct eigenvalues of the scaled operator: two iterations.
  Vector diagonal = random_vector(40).cwiseAbs() + Vector::Ones(40);
  Eigen::MatrixXd M = diagonal.asDiagonal();
  M.bottomRightCorner(20, 20) *= -2.0;
  const Vector b = random_vector(40);
  Vector x;
  const Convergence end = gmres(product(M), diagonal, b, x, {1e-13, 100});
  CHECK(end.converged);
  CHECK(end.iterations == 2);
  CHECK((M * x - b).norm() < 1e-13 * b.norm());  // rounding of two steps
}

TEST_CASE("gmres starts warm, and a zero load gives zero") {
  const SaddleSystem s(3);
  const Vector b = random_vector(s.M.rows());
  Vector x = s.M.partialPivLu().solve(b);
  CHECK(gmres(product(s.M), s.diagonal, b, x, {1e-8, 100}).iterations == 0);
  const Convergence zero = gmres(product(s.M), s.diagonal, Vector::Zero(b.size()), x, {1e-8, 100});
  CHECK(zero.converged);
  CHECK(x.norm() == 0.0);
}

TEST_CASE("gmres reports a system without solution as not converged") {
  // A singular operator and a load outside its range: e1 cannot be reached.
  Eigen::MatrixXd M = Eigen::MatrixXd::Identity(6, 6);
  M(0, 0) = 0.0;
  Vector x;
  const Convergence end = gmres(product(M), Vector::Ones(6), Vector::Ones(6), x, {1e-8, 1000});
  CHECK_FALSE(end.converged);
  CHECK(end.residual == approx(std::sqrt(1.0 / 6.0)));  // the unreachable part of the load
  CHECK(end.iterations < 20);

  // A cyclic shift: restarts shorter than its length gain nothing.
  Eigen::MatrixXd shift = Eigen::MatrixXd::Zero(6, 6);
  for (int i = 0; i < 6; ++i) shift((i + 1) % 6, i) = 1.0;
  Vector y;
  const Convergence stuck = gmres(product(shift), Vector::Ones(6), Vector::Unit(6, 0), y, {1e-8, 1000}, 3);
  CHECK_FALSE(stuck.converged);
  CHECK(stuck.iterations == 3);
  CHECK(gmres(product(shift), Vector::Ones(6), Vector::Unit(6, 0), y, {1e-8, 1000}, 6).converged);
}

TEST_CASE("gmres gives the same bits on one and on three threads") {
  const std::ptrdiff_t n = 10000;  // three chunks
  const Vector diagonal = random_vector(n).cwiseAbs() + Vector::Ones(n);
  const Vector b = random_vector(n, 8);
  const auto apply = [&](const Vector& v, Vector& y) {
    y = diagonal.cwiseProduct(v);
    y.head(n - 1) += 0.3 * v.tail(n - 1);
  };
  Vector one, three;
  set_threads(1);
  const Convergence end = gmres(apply, diagonal, b, one, {1e-10, 200});
  set_threads(3);
  gmres(apply, diagonal, b, three, {1e-10, 200});
  set_threads(1);
  CHECK(end.converged);
  CHECK((one.array() == three.array()).all());
}

TEST_CASE("gmres refuses a scaling that is not positive and numbers that are not finite") {
  const Eigen::MatrixXd M = Eigen::MatrixXd::Identity(3, 3);
  Vector x, b = Vector::Ones(3);
  CHECK_THROWS_WITH_AS(gmres(product(M), Vector(Vector3(1, 0, 1)), b, x, {}),
                       "gmres: diagonal[1] = 0; must be > 0 and finite.", InvalidInput);
  CHECK_THROWS_AS(gmres(product(M), Vector::Ones(3), b, x, {}, 0), InvalidInput);
  const auto broken = [](const Vector& v, Vector& y) { y = v * std::numeric_limits<double>::infinity(); };
  CHECK_THROWS_WITH_AS(gmres(broken, Vector::Ones(3), b, x, {}), doctest::Contains("must be finite"), SolveFailed);
  b[1] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(gmres(product(M), Vector::Ones(3), b, x, {}), SolveFailed);
}

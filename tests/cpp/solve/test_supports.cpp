#include <doctest/doctest.h>

#include <Eigen/Cholesky>

#include "lattice.hpp"
#include "plica/core/error.hpp"
#include "plica/solve/supports.hpp"

using namespace plica;
using plica_test::random_vector;
using plica_test::spring_lattice;

TEST_CASE("fixed unknowns are those that were fixed") {
  Supports supports(4);
  supports.fix(1);
  supports.fix(3, 2);
  supports.fix(3, 2);
  CHECK(supports.size() == 12);
  CHECK(supports.fixed_count() == 4);
  CHECK(supports.node_fixed(1));
  CHECK_FALSE(supports.node_fixed(3));
  CHECK(supports.fixed(11));
  CHECK_FALSE(supports.fixed(10));
  Vector v = Vector::LinSpaced(12, 1.0, 12.0);
  supports.project(v);
  CHECK(v.segment<3>(3).norm() == 0.0);
  CHECK(v[11] == 0.0);
  CHECK(v[10] == 11.0);
}

TEST_CASE("a constrained matrix is the free part beside a multiple of the identity") {
  BlockMatrix A = spring_lattice(3, 0.0);
  const Eigen::MatrixXd before = A.to_sparse();
  Supports supports(27);
  supports.fix(0);
  supports.fix(13, 1);
  supports.constrain(A);
  const Eigen::MatrixXd after = A.to_sparse();
  double mean = 0.0;
  for (int i = 0; i < 81; ++i) mean += supports.fixed(i) ? 0.0 : before(i, i) / 77.0;
  double held = 0.0, kept = 0.0;
  for (int i = 0; i < 81; ++i) {
    for (int j = 0; j < 81; ++j) {
      const bool is_held = supports.fixed(i) || supports.fixed(j);
      const double expected = is_held ? (i == j ? mean : 0.0) : before(i, j);
      (is_held ? held : kept) = std::max(is_held ? held : kept, std::abs(after(i, j) - expected));
    }
  }
  CHECK(kept == 0.0);
  CHECK(held < 1e-13);  // rounding of a sum of 77 terms
}

TEST_CASE("the solution of a constrained system is that of the free unknowns alone") {
  BlockMatrix A = spring_lattice(3, 0.0);
  const Eigen::MatrixXd full = A.to_sparse();
  Supports supports(27);
  for (int node = 0; node < 9; ++node) supports.fix(node);  // a face
  supports.constrain(A);
  Vector b = random_vector(81);
  supports.project(b);
  const Vector x = Eigen::MatrixXd(A.to_sparse()).llt().solve(b);
  const Vector free = full.bottomRightCorner(54, 54).llt().solve(b.tail(54));
  CHECK(x.head(27).norm() == 0.0);
  CHECK((x.tail(54) - free).norm() < 1e-12 * free.norm());  // condition number below 1e3
}

TEST_CASE("nodes, components and sizes outside the range are refused") {
  Supports supports(4);
  CHECK_THROWS_WITH_AS(supports.fix(4), "Supports: node = 4; must be in [0, 4).", InvalidInput);
  CHECK_THROWS_AS(supports.fix(-1), InvalidInput);
  CHECK_THROWS_AS(supports.fix(0, 3), InvalidInput);
  Vector v = Vector::Zero(9);
  CHECK_THROWS_AS(supports.project(v), InvalidInput);
  BlockMatrix A = spring_lattice(2);
  CHECK_THROWS_AS(supports.constrain(A), InvalidInput);
}

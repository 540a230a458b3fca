#include <doctest/doctest.h>

#include <Eigen/LU>

#include "lattice.hpp"
#include "plica/core/error.hpp"
#include "plica/solve/compliance.hpp"

using namespace plica;
using plica_test::spring_lattice;

namespace {

struct Held {
  BlockMatrix A = spring_lattice(4);
  Supports supports{64};
  Indices nodes{{40, 3, 21, 63, 5, 17}};
  Held() {
    for (int node = 0; node < 4; ++node) supports.fix(node);
    supports.fix(21, 1);
    supports.constrain(A);
  }
  std::unique_ptr<const LinearSolver> solver(int max_iterations = 1000) const {
    return LinearSolver::make(A, {1e-8, LinearSolver::ConjugateGradients{max_iterations}});
  }
};

}  // namespace

TEST_CASE("columns are those of the dense inverse, zero where the unknown is held") {
  const Held held;
  const auto solver = held.solver();
  Compliance compliance(*solver, held.supports, held.nodes, 1e-12);
  compliance.require({0, 1, 2, 3, 4, 5, 0});
  const Eigen::MatrixXd inverse = Eigen::MatrixXd(held.A.to_sparse()).inverse();
  double error = 0.0, size = 0.0;
  for (int j = 0; j < 18; ++j) {
    const int unknown = 3 * held.nodes[j / 3] + j % 3;
    const double* column = compliance.column(j / 3, j % 3);
    for (int i = 0; i < 18; ++i) {
      const int row = 3 * held.nodes[i / 3] + i % 3;
      const bool zero = held.supports.fixed(unknown) || held.supports.fixed(row);
      if (zero) CHECK(column[i] == 0.0);
      const double expected = zero ? 0.0 : inverse(row, unknown);
      error = std::max(error, std::abs(column[i] - expected));
      size = std::max(size, std::abs(expected));
    }
  }
  CHECK(size > 0.01);
  CHECK(error < 1e-9 * size);  // condition number, some 1e3, times the tolerance
}

TEST_CASE("a column has the same bits whenever and with whomever it was computed") {
  const Held held;
  const auto solver = held.solver();
  Compliance together(*solver, held.supports, held.nodes, 1e-8);
  Compliance one_by_one(*solver, held.supports, held.nodes, 1e-8);
  together.require({5, 4, 3, 2, 1, 0});
  for (int node : {2, 0, 5}) one_by_one.require({node});
  for (int node : {2, 0, 5}) {
    for (int c = 0; c < 3; ++c) {
      CHECK(std::equal(together.column(node, c), together.column(node, c) + 18, one_by_one.column(node, c)));
    }
  }
}

TEST_CASE("a column stays where it is when others are added") {
  const Held held;
  const auto solver = held.solver();
  Compliance compliance(*solver, held.supports, held.nodes, 1e-8);
  compliance.require({0});
  const double* before = compliance.column(0, 2);
  const double value = before[2];
  CHECK(value > 0.0);
  compliance.require({0, 1, 2, 3, 4, 5});
  CHECK(compliance.column(0, 2) == before);
  CHECK(before[2] == value);
}

TEST_CASE("a column that does not converge fails with its place") {
  const Held held;
  const auto solver = held.solver(2);
  Compliance compliance(*solver, held.supports, held.nodes, 1e-12);
  CHECK_THROWS_WITH_AS(compliance.require({3}), doctest::Contains("unit force on node 63 along x"), SolveFailed);
  CHECK_THROWS_AS(compliance.column(3, 0), InvalidInput);
}

TEST_CASE("places outside the range and columns not yet there are refused") {
  const Held held;
  const auto solver = held.solver();
  Compliance compliance(*solver, held.supports, held.nodes, 1e-8);
  CHECK_THROWS_AS(compliance.require({6}), InvalidInput);
  CHECK_THROWS_AS(compliance.column(-1, 0), InvalidInput);
  CHECK_THROWS_WITH_AS(compliance.column(2, 0), doctest::Contains("Call require."), InvalidInput);
  compliance.require({2});
  CHECK_THROWS_AS(compliance.column(2, 3), InvalidInput);
  CHECK_THROWS_AS(Compliance(*solver, held.supports, Indices::Constant(1, 64), 1e-8), InvalidInput);
  CHECK_THROWS_AS(Compliance(*solver, Supports(3), held.nodes, 1e-8), InvalidInput);
}

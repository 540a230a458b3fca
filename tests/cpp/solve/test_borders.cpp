#include "../borders.hpp"
#include "lattice.hpp"
#include "plica/solve/factorization.hpp"
#include "plica/solve/linear_solver.hpp"
#include "plica/solve/supports.hpp"
#include "plica/solve/triangular_factor.hpp"

using namespace plica;
using borders::Empty;
using borders::Longer;
using borders::numbers;
using borders::refused;
using borders::sizes;
using plica_test::random_vector;
using plica_test::spring_lattice;

TEST_CASE("solvers refuse right-hand sides, starts and products of another size") {
  const BlockMatrix A = spring_lattice(2);
  const std::ptrdiff_t n = A.rows();
  Vector b = random_vector(n), x = random_vector(n);
  Eigen::MatrixXd B(n, 2), X;
  B << b, x;

  const ConjugateGradient gradient(A, {});
  sizes("ConjugateGradient::solve b", b, [&] { gradient.solve(b, x); });
  sizes(
      "ConjugateGradient::solve x", x, [&] { gradient.solve(b, x); }, Longer::refused, Empty::none);
  sizes("ConjugateGradient::solve_many B", B, [&] { gradient.solve_many(B, X); });
  sizes("ConjugateGradient::precondition r", b, [&] { gradient.precondition(b, x); });

  std::ptrdiff_t begin = 0, end = n / 3;
  Vector r = b, z = b;
  const auto diagonal = [&] { gradient.precondition_rows(begin, end, r, z); };
  const auto rounded = [&] { gradient.multiply_rounded_rows(begin, end, r, z); };
  numbers<std::ptrdiff_t>("ConjugateGradient::precondition_rows begin", begin, {-1, end + 1, 1 << 30}, diagonal);
  numbers<std::ptrdiff_t>("ConjugateGradient::precondition_rows end", end, {-1, n / 3 + 1, 1 << 30}, diagonal);
  sizes("ConjugateGradient::precondition_rows r", r, diagonal);
  sizes("ConjugateGradient::precondition_rows z", z, diagonal);
  numbers<std::ptrdiff_t>("ConjugateGradient::multiply_rounded_rows begin", begin, {-1, end + 1, 1 << 30},
                          rounded);
  numbers<std::ptrdiff_t>("ConjugateGradient::multiply_rounded_rows end", end, {-1, n / 3 + 1, 1 << 30}, rounded);
  sizes("ConjugateGradient::multiply_rounded_rows p", r, rounded);
  sizes("ConjugateGradient::multiply_rounded_rows q", z, rounded);

  SparseMatrix sparse = A.to_sparse();
  const Factorization factor(sparse);
  sizes("Factorization::solve b", b, [&] { factor.solve(b); });
  refused("Factorization::Factorization A", [] { Factorization(SparseMatrix(0, 0)); });
  refused("Factorization::Factorization A", [] { Factorization(SparseMatrix(3, 4)); });

  for (const LinearSolver::Method& method :
       {LinearSolver::Method(linear::Cholesky{}), LinearSolver::Method(linear::ConjugateGradients{})}) {
    const auto solver = LinearSolver::make(A, {1e-8, method});
    Vector start = x;
    const auto solve = [&] {
      Guess guess{start, {}};
      solver->solve(b, guess);
    };
    sizes("LinearSolver::solve b", b, solve);
    sizes("LinearSolver::solve guess.x", start, solve, Longer::refused, Empty::none);
    sizes("LinearSolver::solve_many B", B, [&] { solver->solve_many(B, X, 1e-8); });
  }
  const auto cholesky = LinearSolver::make(A, {1e-8, linear::Cholesky{}});
  Vector product = A * x;
  sizes(
      "LinearSolver::solve guess.product", product,
      [&] {
        Guess guess{x, product};
        cholesky->solve(b, guess);
      },
      Longer::refused, Empty::none);
  for (const std::ptrdiff_t size : {std::ptrdiff_t{0}, n - 1, n + 1})
    refused("LinearSolver::solve product", [&] {
      Guess guess;
      cholesky->solve(b, guess, 1e-8, [&](const Vector&, Vector& image) { image = Vector::Ones(size); });
    });

  const TriangularFactor triangular(A, FactorPlan(A));
  sizes("TriangularFactor::solve b", b, [&] { triangular.solve(b, x); });
  refused("TriangularFactor::TriangularFactor plan", [&] { TriangularFactor(spring_lattice(3), FactorPlan(A)); });
}

TEST_CASE("gmres refuses vectors of another size, of its operator too") {
  const BlockMatrix A = spring_lattice(2);
  const std::ptrdiff_t n = A.rows();
  Vector b = random_vector(n), x = random_vector(n), diagonal = Vector::Ones(n);
  int restart = 50;
  const std::function<void(const Vector&, Vector&)> apply = [&](const Vector& v, Vector& image) {
    A.multiply(v, image);
  };
  const auto solve = [&] { gmres(apply, diagonal, b, x, {}, restart); };
  sizes("gmres b", b, solve);
  sizes("gmres diagonal", diagonal, solve);
  sizes("gmres x", x, solve, Longer::refused, Empty::none);
  numbers("gmres restart", restart, {0, -1}, solve);
  x = Vector();
  for (const std::ptrdiff_t size : {std::ptrdiff_t{0}, n - 1, n + 1})
    refused("gmres apply",
            [&] { gmres([&](const Vector&, Vector& image) { image = Vector::Ones(size); }, diagonal, b, x, {}); });
}

TEST_CASE("supports refuse nodes, components and unknowns that are not there") {
  std::ptrdiff_t nodes = 4, unknown = 0;
  numbers<std::ptrdiff_t>("Supports::Supports nodes", nodes, {-1}, [&] { Supports{nodes}; });
  Supports supports(8);
  std::int32_t node = 0;
  int component = 0;
  numbers<std::int32_t>("Supports::fix node", node, {-1, 8, 1 << 30}, [&] { supports.fix(node); });
  numbers<std::int32_t>("Supports::fix node", node, {-1, 8, 1 << 30}, [&] { supports.fix(node, 0); });
  numbers("Supports::fix component", component, {-1, 3}, [&] { supports.fix(0, component); });
  numbers<std::ptrdiff_t>("Supports::fixed unknown", unknown, {-1, 24}, [&] { supports.fixed(unknown); });
  numbers<std::int32_t>("Supports::node_fixed node", node, {-1, 8, 1 << 30}, [&] { supports.node_fixed(node); });
  Vector v = Vector::Ones(24);
  sizes("Supports::project v", v, [&] { supports.project(v); });
  BlockMatrix other = spring_lattice(3);
  refused("Supports::constrain A", [&] { supports.constrain(other); });
}

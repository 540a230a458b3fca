#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "lattice.hpp"
#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "plica/mesh/block.hpp"
#include "plica/solve/bisection.hpp"
#include "plica/solve/cholesky_solver.hpp"
#include "plica/solve/factorization.hpp"
#include "plica/solve/supports.hpp"
#include "plica/tissue/assembly.hpp"

using namespace plica;
using plica_test::random_vector;
using plica_test::spring_lattice;

namespace {

/// A positive definite matrix on a random graph: B B^T of blocks on random edges, plus a little on the diagonal.
BlockMatrix random_matrix(int nodes, int edges, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> any(0, nodes - 1);
  std::vector<std::array<int, 2>> joined;
  Eigen::MatrixXi graph = Eigen::MatrixXi::Identity(nodes, nodes);
  for (int k = 0; k < edges; ++k) {
    const int i = any(random), j = any(random);
    if (i == j) continue;
    joined.push_back({i, j});
    graph(i, j) = graph(j, i) = 1;
  }
  auto pattern = std::make_shared<NodePattern>();
  pattern->row_start.push_back(0);
  for (int i = 0; i < nodes; ++i) {
    for (int j = 0; j < nodes; ++j)
      if (graph(i, j)) pattern->column.push_back(j);
    pattern->row_start.push_back(static_cast<std::int32_t>(pattern->column.size()));
  }
  BlockMatrix A(pattern);
  using Block = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
  std::normal_distribution<double> normal;
  const auto add = [&](int i, int j, const Matrix3& block) { Block(A.block(pattern->find(i, j))) += block; };
  for (int i = 0; i < nodes; ++i) add(i, i, 0.1 * Matrix3::Identity());
  for (const auto& [i, j] : joined) {
    const Matrix3 p = Matrix3::NullaryExpr([&] { return normal(random); });
    const Matrix3 q = Matrix3::NullaryExpr([&] { return normal(random); });
    add(i, i, p * p.transpose());
    add(j, j, q * q.transpose());
    add(i, j, p * q.transpose());
    add(j, i, q * p.transpose());
  }
  return A;
}

/// The matrix of a step for a held block of tissue.
BlockMatrix tissue_matrix(double step, double nu = 0.45) {
  const TetMesh mesh = to_quadratic(block_mesh({{0, 0, 0}, {0.02, 0.01, 0.01}, {4, 3, 3}}));
  const Tissue tissue{{{Isotropic{20e3, nu}, 1040.0, 0.0}}, {"body"}, Indices::Zero(mesh.cell_count())};
  const Assembler assembler(mesh);
  BlockMatrix A = assembler.stiffness(tissue);
  for (double& value : A.values()) value *= 0.25 * step * step;
  const NodalMatrix M = assembler.mass(tissue);
  for (std::size_t e = 0; e < M.values().size(); ++e)
    for (int d = 0; d < 3; ++d) A.values()[9 * e + 4 * d] += M.values()[e];
  Supports supports(mesh.node_count());
  for (const auto node : mesh.node_set("x_min")) supports.fix(node);
  for (const auto node : mesh.node_set("x_max")) supports.fix(node, 1);
  supports.constrain(A);
  return A;
}

Vector solved(const BlockMatrix& A, const Vector& b, double tolerance) {
  Guess guess;
  const Convergence end = CholeskySolver(A, FactorPlan(A), tolerance).solve(b, guess);
  CHECK(end.converged);
  CHECK((b - A * guess.x).norm() <= tolerance * b.norm());
  CHECK((A * guess.x - guess.product).norm() == 0.0);
  return guess.x;
}

double relative(const Vector& a, const Vector& b) { return (a - b).norm() / b.norm(); }

}  // namespace

TEST_CASE("both orders take every node once") {
  const BlockMatrix A = spring_lattice(7);
  for (Order order : {nested_dissection(*A.pattern()), minimum_degree(*A.pattern())}) {
    std::sort(order.begin(), order.end());
    Order all(343);
    std::iota(all.begin(), all.end(), 0);
    CHECK(order == all);
  }
}

TEST_CASE("a bisection leaves no edge between its sides and a separator near that of a plane") {
  const int side = 12;
  const NodePattern p = *spring_lattice(side).pattern();
  Graph graph;
  for (std::int32_t i = 0; i < p.rows(); ++i) {
    for (std::int32_t e = p.row_start[i]; e < p.row_start[i + 1]; ++e)
      if (p.column[e] != i) graph.neighbour.push_back(p.column[e]);
    graph.start.push_back(static_cast<std::int32_t>(graph.neighbour.size()));
  }
  graph.weight.assign(static_cast<std::size_t>(p.rows()), 1);
  graph.multiplicity.assign(graph.neighbour.size(), 1);
  const std::vector<Half> half = bisect(graph);
  std::array<int, 3> count{};
  for (std::int32_t i = 0; i < p.rows(); ++i) {
    ++count[static_cast<std::size_t>(half[i])];
    for (std::int32_t e = graph.start[i]; e < graph.start[i + 1]; ++e) {
      const bool joined = half[i] == Half::left && half[graph.neighbour[e]] == Half::right;
      CHECK_FALSE(joined);
    }
  }
  CHECK(std::max(count[0], count[1]) <= 11 * p.rows() / 20);
  CHECK(count[2] <= side * side * 5 / 4);  // a plane of nodes is the least; a quarter more is a bisection still
}

TEST_CASE("supernodes hold the pattern of the factor that a dense elimination finds") {
  const BlockMatrix A = random_matrix(60, 90, 3);
  const NodePattern& p = *A.pattern();
  for (const Order& order : {nested_dissection(p), minimum_degree(p)}) {
    const Supernodes tree = supernodes(p, order);
    const auto n = static_cast<std::int32_t>(p.rows());
    Eigen::MatrixXi fill = Eigen::MatrixXi::Zero(n, n);
    for (std::int32_t i = 0; i < n; ++i)
      for (std::int32_t j = 0; j < n; ++j) fill(i, j) = p.find(tree.order[i], tree.order[j]) >= 0;
    for (std::int32_t k = 0; k < n; ++k)
      for (std::int32_t i = k + 1; i < n; ++i)
        if (fill(i, k))
          for (std::int32_t j = k + 1; j < n; ++j) fill(i, j) |= fill(j, k);
    for (std::int32_t k = 0; k < n; ++k) {
      const std::int32_t s = tree.supernode_of[k];
      for (std::int32_t i = k + 1; i < n; ++i) {
        if (!fill(i, k)) continue;
        const auto begin = tree.row.begin() + tree.row_start[s], end = tree.row.begin() + tree.row_start[s + 1];
        const bool held = i < tree.first[s + 1] || std::binary_search(begin, end, i);
        CHECK(held);
      }
    }
  }
}

TEST_CASE("Cholesky equals a dense factorisation on random graphs, connected or not") {
  for (const auto& [nodes, edges] :
       {std::pair{1, 0}, {2, 1}, {5, 3}, {40, 25}, {60, 90}, {150, 600}, {300, 500}}) {
    CAPTURE(nodes);
    const BlockMatrix A = random_matrix(nodes, edges, static_cast<unsigned>(nodes));
    const Vector b = random_vector(A.rows());
    const Vector reference = Eigen::MatrixXd(A.to_sparse()).llt().solve(b);
    // Error <= condition number (some 1e3) times the tolerance.
    CHECK(relative(solved(A, b, 1e-12), reference) < 1e-9);
  }
}

TEST_CASE("the factor alone is as good as single precision allows") {
  const BlockMatrix A = tissue_matrix(50e-6);
  const TriangularFactor factor(A, FactorPlan(A));
  const Vector b = random_vector(A.rows());
  Vector x;
  factor.solve(b, x);
  const double residual = (b - A * x).norm() / b.norm();
  CHECK(residual > 1e-9);  // single precision it is
  CHECK(residual < 1e-5);  // 6e-8 times a condition number of some 100
}

TEST_CASE("sixteen right-hand sides at once are solved as eight are, to the bit") {
  const BlockMatrix A = tissue_matrix(50e-6);
  const TriangularFactor factor(A, FactorPlan(A));
  constexpr std::ptrdiff_t pack = TriangularFactor::pack, wide = TriangularFactor::wide;
  const Vector b = random_vector(wide * A.rows());
  Vector x(b.size());
  factor.solve_wide(b.data(), x.data());
  for (std::ptrdiff_t half = 0; half < wide / pack; ++half) {
    Vector part(pack * A.rows()), solved(part.size());
    for (std::ptrdiff_t i = 0; i < part.size(); ++i) part[i] = b[wide * (i / pack) + pack * half + i % pack];
    factor.solve_packed(part.data(), solved.data());
    CHECK(solved.cwiseAbs().maxCoeff() > 0.0);
    std::ptrdiff_t other = 0;
    for (std::ptrdiff_t i = 0; i < part.size(); ++i)
      other += solved[i] != x[wide * (i / pack) + pack * half + i % pack];
    CHECK(other == 0);
  }
}

TEST_CASE("Cholesky agrees with conjugate gradients on tissue with supports") {
  for (const double step : {50e-6, 1e-3}) {
    const BlockMatrix A = tissue_matrix(step);
    const Vector b = random_vector(A.rows());
    Vector iterated;
    CHECK(ConjugateGradient(A, {1e-12, 5000}).solve(b, iterated).converged);
    CHECK(relative(solved(A, b, 1e-12), iterated) < 1e-8);  // the condition number times the tolerance
  }
}

TEST_CASE("badly conditioned matrices are solved to the tolerance nevertheless") {
  for (const double ground : {1e-6, 2.5e-8}) {
    CAPTURE(ground);
    const BlockMatrix A = spring_lattice(6, ground);
    const Vector b = random_vector(A.rows()) * 1e-3 + A * Vector::Constant(A.rows(), 1e3);
    CHECK(relative(solved(A, b, 1e-8), Factorization(A.to_sparse()).solve(b)) < 1e-6);
  }
  const BlockMatrix A = tissue_matrix(1.0, 0.4999);  // statics, nearly
  const Vector b = random_vector(A.rows());
  CHECK(relative(solved(A, b, 1e-10), Factorization(A.to_sparse()).solve(b)) < 1e-6);
}

TEST_CASE("Cholesky gives the same bits on one, two, three and eight threads") {
  const BlockMatrix A = spring_lattice(12);
  const Vector b = random_vector(A.rows());
  Eigen::MatrixXd B(A.rows(), 3), one_many, many;
  for (int c = 0; c < 3; ++c) B.col(c) = random_vector(A.rows(), 30 + c);
  Guess one, other;
  set_threads(1);
  {
    const CholeskySolver solver(A, FactorPlan(A), 1e-8);
    solver.solve(b, one);
    solver.solve_many(B, one_many, 1e-8);
  }
  for (const int count : {2, 3, 8}) {
    set_threads(count);
    const CholeskySolver solver(A, FactorPlan(A), 1e-8);
    other = {};
    solver.solve(b, other);
    solver.solve_many(B, many, 1e-8);
    CHECK((one.x.array() == other.x.array()).all());
    CHECK((one_many.array() == many.array()).all());
  }
  set_threads(1);
}

TEST_CASE("a right-hand side gets the bits it gets in other company") {
  for (const double ground : {0.05, 1e-7}) {  // refined; and finished by conjugate gradients
    CAPTURE(ground);
    const BlockMatrix A = spring_lattice(6, ground);
    const int count = 11;
    Eigen::MatrixXd B(A.rows(), count), X;
    for (int c = 0; c < count; ++c) B.col(c) = random_vector(A.rows(), 20 + c) * std::pow(10.0, 8 * (c - 5));
    B.col(4).setZero();
    const CholeskySolver solver(A, FactorPlan(A), 1e-8);
    const auto ends = solver.solve_many(B, X, 1e-8);
    for (int c = 0; c < count; ++c) {
      CAPTURE(c);
      Eigen::MatrixXd alone;
      const auto end = solver.solve_many(B.col(c), alone, 1e-8);
      CHECK(end[0].iterations == ends[c].iterations);
      CHECK((alone.col(0).array() == X.col(c).array()).all());
      CHECK(ends[c].converged);
      const Vector b = B.col(c), x = X.col(c);
      CHECK((b - A * x).norm() <= 1e-8 * b.norm());
    }
  }
}

TEST_CASE("a known product saves the first one and a wrong one is found out") {
  const BlockMatrix A = spring_lattice(6);
  const Vector b = random_vector(A.rows());
  const CholeskySolver solver(A, FactorPlan(A), 1e-8);
  Guess guess;
  guess.x = random_vector(A.rows(), 5);
  guess.product = A * guess.x;
  Guess unknown{guess.x, {}};
  solver.solve(b, guess);
  solver.solve(b, unknown);
  CHECK(guess.x == unknown.x);
  Guess wrong{random_vector(A.rows(), 5), b};  // claims to be the solution
  CHECK(solver.solve(b, wrong).converged);
  CHECK((b - A * wrong.x).norm() <= 1e-8 * b.norm());
}

TEST_CASE("a zero load gives zero whatever the start, and a start at the solution takes no solve") {
  const BlockMatrix A = spring_lattice(4);
  const CholeskySolver solver(A, FactorPlan(A), 1e-8);
  Guess guess{random_vector(A.rows()), {}};
  CHECK(solver.solve(Vector::Zero(A.rows()), guess).converged);
  CHECK(guess.x == Vector::Zero(A.rows()));
  const Vector b = random_vector(A.rows());
  solver.solve(b, guess);
  CHECK(solver.solve(b, guess).iterations == 0);
}

TEST_CASE("Cholesky refuses what is indefinite, singular or not finite") {
  BlockMatrix A = spring_lattice(4);
  const NodePattern& p = *A.pattern();
  for (int k = 0; k < 3; ++k) {
    A.block(p.find(0, 1))[4 * k] -= 100.0;
    A.block(p.find(1, 0))[4 * k] -= 100.0;
  }
  CHECK_THROWS_WITH_AS(TriangularFactor(A, FactorPlan(A)),
                       doctest::Contains("not positive definite: pivot of node"), SolveFailed);
  const BlockMatrix floating = spring_lattice(4, 0.0);
  CHECK_THROWS_WITH_AS(TriangularFactor(floating, FactorPlan(floating)),
                       doctest::Contains("A body without support"), SolveFailed);
  BlockMatrix bad = spring_lattice(3);
  bad.block(bad.pattern()->find(5, 5))[4] = -1.0;
  CHECK_THROWS_WITH_AS(TriangularFactor(bad, FactorPlan(bad)),
                       doctest::Contains("diagonal entry of node 5 along y = -1"), SolveFailed);
  BlockMatrix nan = spring_lattice(3);
  nan.block(nan.pattern()->find(4, 5))[4] = nan.block(nan.pattern()->find(5, 4))[4] =
      std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(TriangularFactor(nan, FactorPlan(nan)), SolveFailed);
  const BlockMatrix good = spring_lattice(3);
  const CholeskySolver solver(good, FactorPlan(good), 1e-8);
  Vector b = random_vector(good.rows());
  Guess guess;
  CHECK_THROWS_AS(solver.solve(Vector::Ones(5), guess), InvalidInput);
  b[4] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH_AS(solver.solve(b, guess), doctest::Contains("must be finite"), SolveFailed);
  auto one_sided = std::make_shared<NodePattern>();
  one_sided->row_start = {0, 2, 3};
  one_sided->column = {0, 1, 1};
  CHECK_THROWS_WITH_AS(FactorPlan{BlockMatrix(one_sided)}, doctest::Contains("symmetric pattern"), InvalidInput);
}

TEST_CASE("solvers are chosen by name, by memory and by what they stream") {
  const BlockMatrix A = spring_lattice(8);
  const LinearSolver::Method automatic = LinearSolver::Automatic{}, cholesky = LinearSolver::Cholesky{},
                             iterated = LinearSolver::ConjugateGradients{};
  const auto named = [](const BlockMatrix& matrix, const LinearSolver::Method& method) {
    return LinearSolver::make(matrix, {1e-8, method})->name();
  };
  CHECK(named(A, cholesky) == "Cholesky");
  CHECK(named(A, iterated) == "conjugate gradients");
  CHECK(named(A, LinearSolver::Automatic{0.0}) == "conjugate gradients");
  CHECK(named(tissue_matrix(1e-3), automatic) == "Cholesky");
  const Vector b = random_vector(A.rows());
  for (const LinearSolver::Method& method : {automatic, cholesky, iterated}) {
    const auto solver = LinearSolver::make(A, {1e-8, method});
    Guess guess;
    CHECK(solver->solve(b, guess).converged);
    CHECK((b - A * guess.x).norm() <= 1e-8 * b.norm());
    CHECK(solver->tolerance() == 1e-8);
    Eigen::MatrixXd X;
    CHECK(solver->solve_many(b, X, 1e-12)[0].converged);
    CHECK((b - A * X.col(0)).norm() <= 2e-12 * b.norm());
  }
  using Options = LinearSolver::Options;
  CHECK_THROWS_WITH_AS((Options{2.0, cholesky}.validate()), "LinearSolver: tolerance = 2; must be in (0, 1).",
                       InvalidInput);
  CHECK_THROWS_AS((Options{1e-8, LinearSolver::Automatic{-1.0}}.validate()), InvalidInput);
  CHECK_THROWS_AS((Options{1e-8, LinearSolver::Cholesky{0}}.validate()), InvalidInput);
  CHECK_THROWS_WITH_AS((Options{1e-8, LinearSolver::ConjugateGradients{0}}.validate()),
                       "ConjugateGradients: max_iterations = 0; must be >= 1.", InvalidInput);
}

// The condensed solver, the saddle point and the thesis's GMRES answer the same question: forces and motion are
// held against the complementarity conditions with a dense inverse, and against each other.
#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <array>
#include <string>

#include "../solve/lattice.hpp"
#include "plica/contact/force_solver.hpp"
#include "plica/core/error.hpp"

using namespace plica;
using plica_test::random_vector;

namespace {

constexpr int side = 5;
constexpr double scale = 0.7, gap_tolerance = 1e-9;
const std::array<ContactSolver, 3> solvers{Condensed{}, Saddle{}, Gmres{}};
// GMRES adds 1e-7 of a row's own compliance to it, the others 1e-9.
constexpr double close = 1e-6;

/// Two lattices of springs, one behind the other in the numbering; the first nodes of both are held.
struct Bodies {
  BlockMatrix A = two_lattices();
  Supports supports{A.rows() / 3};
  Indices nodes = Indices::LinSpaced(A.rows() / 3, 0, static_cast<std::int32_t>(A.rows() / 3 - 1));

  Bodies() {
    for (const int held : {0, 1, side * side * side}) supports.fix(held);
    supports.fix(2, 1);
    supports.constrain(A);
  }

  static BlockMatrix two_lattices() {
    const BlockMatrix one = plica_test::spring_lattice(side), other = plica_test::spring_lattice(side, 0.05, 2);
    const NodePattern& p = *one.pattern();
    auto pattern = std::make_shared<NodePattern>(p);
    for (const std::int32_t c : p.column) pattern->column.push_back(c + static_cast<std::int32_t>(p.rows()));
    for (std::size_t r = 1; r < p.row_start.size(); ++r)
      pattern->row_start.push_back(p.row_start[r] + static_cast<std::int32_t>(p.entries()));
    BlockMatrix both(pattern);
    std::copy(one.values().begin(), one.values().end(), both.values().begin());
    std::copy(other.values().begin(), other.values().end(), both.values().begin() + 9 * p.entries());
    return both;
  }
};

/// A row of slave `s` in the one body against nodes of the other, in these shares; its gap is bent away from the
/// force by `bend`.
Row row(int s, const std::array<double, 3>& shares, double bend, double free, double compliance = 0.0) {
  const Vector random = random_vector(6, static_cast<unsigned>(s));
  const Vector3 normal = random.head<3>().normalized();
  Vector3 across = random.tail<3>();
  across -= normal.dot(across) * normal;
  const Vector3 gradient = normal + bend * across.normalized();
  Row made{{{s, normal}}, {{s, gradient}}, free, compliance};
  for (int k = 0; k < 3; ++k) {
    if (shares[static_cast<std::size_t>(k)] == 0.0) continue;
    const std::int32_t master = side * side * side + s + k;
    made.push.push_back({master, -shares[static_cast<std::size_t>(k)] * normal});
    made.gap.push_back({master, -shares[static_cast<std::size_t>(k)] * gradient});
  }
  return made;
}

/// `count` rows of which about two thirds are inside.
std::vector<Row> rows_of(int count, const std::array<double, 3>& shares, double bend, double compliance = 0.0) {
  std::vector<Row> rows;
  const Vector random = random_vector(count, 5);
  for (int i = 0; i < count; ++i) rows.push_back(row(3 + 4 * i, shares, bend, random[i] - 0.3, compliance));
  return rows;
}

/// A force solver with the linear solver that it takes.
struct OwnedSolver {
  std::unique_ptr<const LinearSolver> linear;
  std::unique_ptr<ForceSolver> forces;
  OwnedSolver(const Bodies& bodies, const ContactSolver& solver, int max_iterations = 5000)
      : linear(LinearSolver::make(bodies.A, {1e-11, LinearSolver::ConjugateGradients{max_iterations}})),
        forces(force_solver(solver, bodies.A, *linear, bodies.supports, bodies.nodes, {1e-11, max_iterations})) {}
  ForceSolver* operator->() const { return forces.get(); }
};

struct Answer {
  Vector force, nodal, change;  // change: A^-1 N^T p as the force solver gives it to a solve with A
  Points x;
};

Answer answer(const Bodies& bodies, const ContactSolver& solver, const std::vector<Row>& rows,
              std::vector<char> guess) {
  const OwnedSolver forces(bodies, solver);
  const Complementarity end = forces->solve(rows, scale, std::move(guess), gap_tolerance, 500);
  REQUIRE(end.converged);
  const Points at_rest = Points::Zero(bodies.nodes.size(), 3);
  Answer given{end.force, Vector::Zero(bodies.A.rows()), Vector::Zero(bodies.A.rows()), at_rest};
  forces->move(rows, end.force, scale, at_rest, given.x);
  for (std::size_t i = 0; i < rows.size(); ++i)
    rows[i].add_force(end.force[static_cast<std::ptrdiff_t>(i)], given.nodal);
  forces->add_response(given.nodal, given.change);
  bodies.supports.project(given.nodal);
  return given;
}

/// All solvers from all guesses obey the conditions and agree; `unique`: also in the single forces. Returns how
/// many rows press.
int check(const std::vector<Row>& rows, bool unique = true) {
  const Bodies bodies;
  const Eigen::MatrixXd A = bodies.A.to_sparse();
  const Eigen::LLT<Eigen::MatrixXd> inverse(A);
  Answer first;
  int pressing = 0;
  for (const ContactSolver& solver : solvers)
    for (const char guess : {0, 1}) {
      CAPTURE(std::string(name_of(solver)));
      CAPTURE(int(guess));
      const Answer found = answer(bodies, solver, rows, std::vector<char>(rows.size(), guess));
      const Vector exact = inverse.solve(found.nodal);
      const double size = exact.cwiseAbs().maxCoeff();
      CHECK((as_vector(found.x) - scale * exact).cwiseAbs().maxCoeff() <= 1e-8 * scale * size);
      // The condensed solver keeps its far columns in single precision.
      CHECK((found.change - exact).cwiseAbs().maxCoeff() <= 1e-5 * size);
      pressing = 0;
      for (std::size_t i = 0; i < rows.size(); ++i) {
        const double p = found.force[static_cast<std::ptrdiff_t>(i)];
        const double gap = rows[i].free + scale * rows[i].along(exact) + rows[i].compliance * p;
        CHECK(p >= 0);
        CHECK(gap >= -close);
        CHECK(p * std::abs(gap) <= close * found.force.cwiseAbs().maxCoeff());
        pressing += p > 0;
      }
      if (first.force.size() == 0) first = found;
      CHECK((found.nodal - first.nodal).norm() <= close * first.nodal.norm());
      if (unique) CHECK((found.force - first.force).norm() <= close * first.force.norm());
    }
  return pressing;
}

const std::array<double, 3> matched{1, 0, 0}, shared{0.2, 0.3, 0.5};

}  // namespace

TEST_CASE("all solvers give the same forces and motion on matched, non-matching and bent surfaces") {
  for (const auto& shares : {matched, shared})
    for (const double bend : {0.0, 0.2, 1.0}) {
      CAPTURE(shares[0]);
      CAPTURE(bend);
      const int pressing = check(rows_of(20, shares, bend));
      CHECK(pressing > 5);
      CHECK(pressing < 20);
    }
}

TEST_CASE("all solvers give a penalty's springs their share of the gap") {
  for (const double compliance : {1e-3, 1.0, 10.0}) CHECK(check(rows_of(20, shared, 0.2, compliance)) > 5);
  std::vector<Row> mixed = rows_of(20, shared, 0.2);
  for (std::size_t i = 0; i < mixed.size(); i += 2) mixed[i].compliance = 1.0;
  CHECK(check(mixed) > 5);
}

TEST_CASE("all solvers share a force among rows that repeat each other, with one motion") {
  std::vector<Row> rows = rows_of(12, shared, 0.2);
  for (const std::size_t i : {0, 1, 2, 3, 1}) rows.push_back(rows[i]);
  // Seen from either side: the same row with both sides exchanged and the force reversed twice.
  Row seen = rows_of(12, matched, 0.0)[4];
  rows.push_back(seen);
  std::swap(seen.push[0], seen.push[1]);
  std::swap(seen.gap[0], seen.gap[1]);
  rows.push_back(seen);
  CHECK(check(rows, false) > 5);
}

TEST_CASE("all solvers agree where nothing touches, everything does, and on a single row") {
  std::vector<Row> open = rows_of(20, shared, 0.2), closed = open;
  for (Row& r : open) r.free = 1.0;
  CHECK(check(open) == 0);
  // What pushes everything by equal forces closes all.
  const Bodies bodies;
  const Eigen::MatrixXd A = bodies.A.to_sparse();
  Vector nodal = Vector::Zero(A.rows());
  for (const Row& r : closed) r.add_force(1.0, nodal);
  bodies.supports.project(nodal);
  const Vector pushed = A.llt().solve(nodal);
  for (Row& r : closed) r.free = -scale * r.along(pushed);
  CHECK(check(closed) == 20);
  CHECK(check({row(3, shared, 0.3, -0.5)}) == 1);
}

TEST_CASE("a row with its slave held pushes the other body alone") {
  for (const int slave : {0, 1, 2}) {
    CAPTURE(slave);
    CHECK(check({row(slave, shared, 0.1, -0.5), row(40, shared, 0.1, -0.2)}) == 2);
  }
}

TEST_CASE("what a solver has solved before changes neither forces nor motion beyond the tolerance") {
  const Bodies bodies;
  const std::vector<Row> rows = rows_of(20, shared, 0.2), others = rows_of(15, matched, 0.5);
  for (const ContactSolver& solver : solvers) {
    CAPTURE(std::string(name_of(solver)));
    const OwnedSolver forces(bodies, solver);
    const std::vector<char> guess(rows.size(), 1);
    const Vector fresh = forces->solve(rows, scale, guess, gap_tolerance, 500).force;
    forces->solve(others, scale, std::vector<char>(others.size(), 1), gap_tolerance, 500);
    const Vector again = forces->solve(rows, scale, guess, gap_tolerance, 500).force;
    CHECK((again - fresh).norm() <= 1e-8 * fresh.norm());
    forces->forget();
    CHECK(forces->solve(rows, scale, guess, gap_tolerance, 500).force == fresh);
  }
}

TEST_CASE("a solver that does not converge, or that nothing can move, says so and what to try") {
  const Bodies bodies;
  const std::vector<Row> rows = rows_of(20, shared, 0.2);
  const std::vector<char> guess(rows.size(), 1);
  for (const ContactSolver& solver : solvers) {
    CAPTURE(std::string(name_of(solver)));
    const OwnedSolver forces(bodies, solver, 3);
    const auto solve = [&] { forces->solve(rows, scale, guess, gap_tolerance, 500); };
    CHECK_THROWS_AS(solve(), SolveFailed);
    const char* advice = std::holds_alternative<Condensed>(solver) ? "Raise max_iterations" : "Try the condensed";
    CHECK_THROWS_WITH(solve(), doctest::Contains(advice));
    const OwnedSolver held(bodies, solver);
    const std::vector<Row> immovable{row(0, matched, 0.0, -0.5)};  // both its nodes are held
    CHECK_THROWS_WITH_AS(held->solve(immovable, scale, {1}, gap_tolerance, 500),
                         doctest::Contains("A contact between two fully fixed bodies?"), SolveFailed);
  }
}

TEST_CASE("auto stands for the condensed solver on few surface nodes and the saddle point on many") {
  CHECK(std::holds_alternative<Condensed>(chosen_solver(Automatic{}, 5000)));
  CHECK(std::holds_alternative<Saddle>(chosen_solver(Automatic{}, 5001)));
  CHECK(std::holds_alternative<Gmres>(chosen_solver(Gmres{}, 5001)));
  CHECK(std::holds_alternative<Condensed>(chosen_solver(Condensed{}, 5001)));
}

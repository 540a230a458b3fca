#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "../approx.hpp"
#include "plica/contact/collision.hpp"
#include "plica/core/error.hpp"

using namespace plica;

namespace {

/// Two unit squares of two triangles each that face each other along z, a unit apart; each node is held by a
/// spring of its own, 1 N/m in every direction, or fixed.
struct Squares {
  Points reference = Points(8, 3);
  Airway airway;
  BlockMatrix stiffness{node_pattern()};
  Supports supports{8};

  explicit Squares(bool fix_first) {
    for (int k = 0; k < 8; ++k) {
      reference.row(k) << k % 2, k / 2 % 2, k / 4;
      for (int c = 0; c < 3; ++c) stiffness.block(k)[4 * c] = 1.0;
      if (fix_first && k < 4) supports.fix(k);
    }
    supports.constrain(stiffness);
    Triangles first(2, 3), second(2, 3);
    first << 0, 1, 3, 0, 3, 2;
    second << 4, 7, 5, 4, 6, 7;
    airway = matched_airway(reference, first, second, Vector3::UnitZ());
  }

  static Pattern node_pattern() {
    auto pattern = std::make_shared<NodePattern>();
    for (int k = 0; k <= 8; ++k) pattern->row_start.push_back(k);
    for (int k = 0; k < 8; ++k) pattern->column.push_back(k);
    return pattern;
  }

  /// The squares with their nodes at these heights.
  Points at(const std::array<double, 8>& heights) const {
    Points x = reference;
    for (int k = 0; k < 8; ++k) x(k, 2) = heights[static_cast<std::size_t>(k)];
    return x;
  }
};

/// One problem that was put to a solver, and how it ended.
struct Question {
  std::vector<Row> rows;
  bool converged;
};

/// The condensed solver, which keeps the questions and the positions that each pass led to.
class RecordingSolver final : public ForceSolver {
 public:
  struct Record {
    std::vector<std::vector<Question>> passes{1};  // the last one is empty: the pass that only checks
    std::vector<Points> x;                         // after each pass
  };
  RecordingSolver(const Squares& squares, std::shared_ptr<Record> record)
      : linear_(LinearSolver::make(squares.stiffness, {1e-13, LinearSolver::ConjugateGradients{100}})),
        condensed_(condensed_solver(*linear_, squares.supports, Indices::LinSpaced(8, 0, 7))),
        record_(std::move(record)) {}

  Complementarity solve(const std::vector<Row>& rows, double scale, std::vector<char> guess, double gap_tolerance,
                        int most_pivots) override {
    Complementarity solution = condensed_->solve(rows, scale, std::move(guess), gap_tolerance, most_pivots);
    record_->passes.back().push_back({rows, solution.converged});
    return solution;
  }
  void move(const std::vector<Row>& rows, const Vector& force, double scale, const Points& x_free,
            Points& x) override {
    condensed_->move(rows, force, scale, x_free, x);
    record_->passes.emplace_back();
    record_->x.push_back(x);
  }

 private:
  std::unique_ptr<const LinearSolver> linear_;
  std::unique_ptr<ForceSolver> condensed_;
  std::shared_ptr<Record> record_;
};

/// The condensed solver, that moves the upper square by `off` (m) too far or not far enough in turn; one that
/// gives up finds forces once only.
class FailingSolver final : public ForceSolver {
 public:
  FailingSolver(const Squares& squares, double off, bool gives_up)
      : linear_(LinearSolver::make(squares.stiffness, {1e-13, LinearSolver::ConjugateGradients{100}})),
        condensed_(condensed_solver(*linear_, squares.supports, Indices::LinSpaced(8, 0, 7))),
        off_(off),
        gives_up_(gives_up) {}

  Complementarity solve(const std::vector<Row>& rows, double scale, std::vector<char> guess, double gap_tolerance,
                        int most_pivots) override {
    Complementarity solution = condensed_->solve(rows, scale, std::move(guess), gap_tolerance, most_pivots);
    if (gives_up_ && moves_ > 0) solution.converged = false;
    return solution;
  }
  void move(const std::vector<Row>& rows, const Vector& force, double scale, const Points& x_free,
            Points& x) override {
    condensed_->move(rows, force, scale, x_free, x);
    ++moves_;
    x.col(2).tail(4).array() += moves_ % 2 ? off_ : -off_;
  }

 private:
  std::unique_ptr<const LinearSolver> linear_;
  std::unique_ptr<ForceSolver> condensed_;
  double off_;
  bool gives_up_;
  int moves_ = 0;
};

/// Moves that miss by `off` m until a search begins anew.
class CarriedSolver final : public ForceSolver {
 public:
  CarriedSolver(const Squares& squares, double off, std::shared_ptr<const bool> anew)
      : linear_(LinearSolver::make(squares.stiffness, {1e-13, LinearSolver::ConjugateGradients{100}})),
        condensed_(condensed_solver(*linear_, squares.supports, Indices::LinSpaced(8, 0, 7))),
        off_(off),
        anew_(std::move(anew)) {}

  Complementarity solve(const std::vector<Row>& rows, double scale, std::vector<char> guess, double gap_tolerance,
                        int most_pivots) override {
    return condensed_->solve(rows, scale, std::move(guess), gap_tolerance, most_pivots);
  }
  void move(const std::vector<Row>& rows, const Vector& force, double scale, const Points& x_free,
            Points& x) override {
    condensed_->move(rows, force, scale, x_free, x);
    if (!*anew_) x.col(2).tail(4).array() -= off_;
  }

 private:
  std::unique_ptr<const LinearSolver> linear_;
  std::unique_ptr<ForceSolver> condensed_;
  double off_;
  std::shared_ptr<const bool> anew_;
};

/// Multipliers that say when a search begins anew.
class HeraldingMethod final : public ContactMethod {
 public:
  explicit HeraldingMethod(std::shared_ptr<bool> anew) : anew_(std::move(anew)) {}
  std::unique_ptr<ConstraintKind> kind(Detector& detector, const FaceMethod& faces) const override {
    return contact_method(Multipliers{})->kind(detector, faces);
  }
  std::vector<std::int32_t> begin(const BeforeContact& before) override {
    *anew_ = true;
    return ContactMethod::begin(before);
  }

 private:
  std::shared_ptr<bool> anew_;
};

TEST_CASE("a force whose constraint is no more has not settled") {
  const auto method = contact_method(Multipliers{});
  const Points x = Points::Zero(2, 3);
  Constraint constraint;
  constraint.key = 3;
  constraint.weights = {{0, 1.0}, {1, -1.0}};
  constraint.normal = constraint.gradient = Vector3::UnitX();
  Contacts last;
  last.constraints = {constraint};
  last.force = Vector::Constant(1, 2.0);
  CHECK(method->settled(last, {constraint}, x, 1e-9));
  CHECK_FALSE(method->settled(last, {}, x, 1e-9));
  Constraint another = constraint;
  another.key = 4;
  CHECK_FALSE(method->settled(last, {another}, x, 1e-9));
  last.force[0] = 0;
  CHECK(method->settled(last, {}, x, 1e-9));
}

/// A method with one constraint, on the height t of node 4: the gap sign(t) sqrt|t|, of which Newton's method
/// leads from t to -t and back.
class SwingingMethod final : public ContactMethod {
 public:
  std::unique_ptr<ConstraintKind> kind(Detector&, const FaceMethod&) const override {
    return std::make_unique<Root>();
  }

 private:
  struct Root final : ConstraintKind {
    static double gap(double t) { return std::copysign(std::sqrt(std::abs(t)), t); }
    void update(const Points&) override {}
    std::vector<std::int32_t> violated(const Points& x, double, const ContactSurface&, double least) override {
      if (gap(x(4, 2)) < -least) return {4};
      return {};
    }
    bool knows(std::int32_t key) const override { return key == 4; }
    Constraint at(std::int32_t key, const Points& x, double) override {
      const double t = x(4, 2), slope = 0.5 / std::sqrt(std::max(std::abs(t), 1e-20));
      Constraint constraint;
      constraint.key = constraint.slave = key;
      constraint.weights = {{key, 1.0}};
      constraint.normal = Vector3::UnitZ();
      constraint.gradient = slope * Vector3::UnitZ();
      constraint.depth = gap(t) - slope * t;
      return constraint;
    }
    std::vector<PressedNode> pressed(const ContactSurface&, const Contact&, const Points&) override { return {}; }
    Vector pressure(const Contact&, const Points&) override { return {}; }
  };
};

/// A collision of the squares from their reference to x_free, with what its solver was asked.
struct Solved {
  std::shared_ptr<RecordingSolver::Record> record = std::make_shared<RecordingSolver::Record>();
  Contacts contacts;
  Points x;
  double tolerance;  // m

  Solved(const Squares& squares, const Points& x_free) {
    Collision collision(squares.airway, squares.reference, contact_method(Multipliers{}), {}, {},
                        std::make_unique<RecordingSolver>(squares, record));
    tolerance = Collision::Options{}.tolerance * collision.detector().mean_edge();
    const std::vector<std::int32_t> none;
    contacts = collision.solve(x_free, 1.0, {squares.reference, none, {}, 0.0}, {}, x);
  }
};

/// No pair is open further inside than the tolerance, none that presses is off the surface by more.
void check_closed(const Squares& squares, const Solved& solved) {
  Detector detector(squares.airway, squares.reference);
  detector.update(solved.x);
  CHECK(solved.contacts.force.minCoeff() >= 0);
  CHECK(solved.contacts.force.maxCoeff() > 0.1);
  for (std::size_t i = 0; i < solved.contacts.constraints.size(); ++i) {
    const double gap = detector.pair(solved.contacts.constraints[i].slave, solved.x).gap(solved.x);
    CHECK(gap >= -solved.tolerance);
    if (solved.contacts.force[static_cast<std::ptrdiff_t>(i)] > 0) CHECK(gap <= solved.tolerance);
  }
}

}  // namespace

TEST_CASE("rows of gap gradients without a solution give way to rows of normals in that pass alone") {
  // A flat square sinks onto a fixed one with a corner bent down: its slaves are then the four nodes above and a
  // node of the fixed square, and in one pass no set of them is consistent by gradients.
  const Squares squares(true);
  const Points x_free = squares.at({0, 0, -0.2, 0, -0.5, -0.5, -0.5, -0.5});
  const Solved solved(squares, x_free);
  Detector detector(squares.airway, squares.reference);
  int fell_back = 0;
  for (std::size_t pass = 0; pass + 1 < solved.record->passes.size(); ++pass) {
    CAPTURE(pass);
    const auto& questions = solved.record->passes[pass];
    const Points& x = pass == 0 ? x_free : solved.record->x[pass - 1];
    detector.update(x);
    for (const Row& row : questions[0].rows)
      CHECK((row.gap[0].vector - detector.pair(row.gap[0].node, x).gradient).norm() < 1e-12);
    CHECK(questions.back().converged);
    REQUIRE(questions.size() == (questions[0].converged ? 1 : 2));
    if (questions[0].converged) continue;
    ++fell_back;
    REQUIRE(pass > 0);  // so that the gaps below are not those of x_free
    for (const Row& row : questions[1].rows) {
      REQUIRE(row.gap.size() == row.push.size());
      for (std::size_t k = 0; k < row.gap.size(); ++k) CHECK(row.gap[k].vector == row.push[k].vector);
      // Moved back from x_free to x along its linear gap, a row has its pair's exact gap there.
      CHECK(row.free + row.moving(x) - row.moving(x_free) ==
            approx(detector.pair(row.push[0].node, x).gap(x)).epsilon(1e-12).scale(1));
    }
  }
  CHECK(fell_back == 1);
  CHECK(solved.contacts.pivots > 30);  // the gradient's active sets are counted
  CHECK(solved.contacts.passes < 10);
  check_closed(squares, solved);
}

TEST_CASE("from the fourth pass on normals are the mean of their own and the last, which ends a swing") {
  // Two squares on springs, bent towards each other at facing corners: with normals not relaxed the four closed
  // pairs swing for ever.
  const Squares squares(false);
  const Points x_free = squares.at({0, 0, 0.4, 0, -0.3, -0.3, -0.7, -0.3});
  const Solved solved(squares, x_free);
  Detector detector(squares.airway, squares.reference);
  int turned = 0;
  std::vector<Row> before;
  for (std::size_t pass = 0; pass + 1 < solved.record->passes.size(); ++pass) {
    CAPTURE(pass);
    const Points& x = pass == 0 ? x_free : solved.record->x[pass - 1];
    detector.update(x);
    const std::vector<Row>& rows = solved.record->passes[pass].back().rows;
    for (const Row& row : rows) {
      const auto [slave, normal] = row.push[0];
      const Vector3 own = detector.pair(slave, x).normal;
      const auto last = std::find_if(before.begin(), before.end(),
                                     [slave = slave](const Row& other) { return other.push[0].node == slave; });
      const bool relaxed = pass >= 3 && last != before.end();
      const Vector3 expected = relaxed ? Vector3((own + last->push[0].vector).normalized()) : own;
      CHECK((normal - expected).norm() < 1e-12);
      turned += relaxed && (normal - own).norm() > 1e-4;
    }
    before = rows;
  }
  CHECK(turned >= 4);
  CHECK(solved.contacts.passes < 15);
  check_closed(squares, solved);
}

TEST_CASE(
    "passes that come no closer end with the closest one, unconverged within ten tolerances, else in words") {
  const Squares squares(true);
  const Points x_free = squares.at({0, 0, 0, 0, -0.5, -0.5, -0.5, -0.5});
  const std::vector<std::int32_t> none;
  const auto solve = [&](double tolerances, bool gives_up, Points& x) {
    const double edge = Detector(squares.airway, squares.reference).mean_edge();
    const double off = tolerances * Collision::Options{}.tolerance * edge;
    Collision collision(squares.airway, squares.reference, contact_method(Multipliers{}), {}, {},
                        std::make_unique<FailingSolver>(squares, off, gives_up));
    return collision.solve(x_free, 1.0, {squares.reference, none, {}, 0.0}, {}, x);
  };
  for (const bool gives_up : {false, true}) {
    CAPTURE(gives_up);
    Points x;
    const Contacts contacts = solve(3, gives_up, x);
    CHECK_FALSE(contacts.converged);
    CHECK(x.col(2).tail(4).cwiseAbs().maxCoeff() == approx(contacts.gap_error).epsilon(1e-6));
    CHECK(contacts.force.sum() == approx(2.0).epsilon(1e-4));  // springs of 1 N/m, half a metre each
    CHECK((gives_up ? contacts.passes < 5 : contacts.passes < Collision::Options{}.max_passes / 2));
    CHECK_THROWS_WITH_AS(solve(30, gives_up, x),
                         doctest::Contains(gives_up ? "no consistent set of closed" : "gap error"), SolveFailed);
    CHECK(solve(0, gives_up, x).converged);
  }
}

TEST_CASE("a search that goes on from what another found ends where one from the start does, in fewer passes") {
  const Squares squares(false);
  const auto collision = [&] {
    return Collision(squares.airway, squares.reference, contact_method(Multipliers{}), {}, {1e-9},
                     std::make_unique<RecordingSolver>(squares, std::make_shared<RecordingSolver::Record>()));
  };
  const std::vector<std::int32_t> none;
  const BeforeContact before{squares.reference, none, {}, 0.0};
  // Pressed together a little more, and drawn apart.
  for (const double further : {0.01, -2.0}) {
    CAPTURE(further);
    const Points x_free = squares.at({0, 0, 0.1, 0, -0.3, -0.3, -0.4, -0.3}),
                 other_free =
                     x_free - further * squares.at({0, 0, 0, 0, 1, 1, 1, 1}).col(2) * Vector3::UnitZ().transpose();
    Points x, resumed_x, x_anew;
    Collision going_on = collision(), anew = collision();
    const Contacts first = going_on.solve(x_free, 1.0, before, {}, x);
    const Contacts resumed = going_on.solve(other_free, 1.0, before, first, resumed_x);
    const Contacts from_start = anew.solve(other_free, 1.0, before, {}, x_anew);
    // Gaps close to 1e-9 either way; across them forces act along the normals that the last pass began with.
    CHECK((resumed_x - x_anew).cwiseAbs().maxCoeff() < (further > 0 ? 1e-4 : 1e-15));
    CHECK(resumed.any_force() == (further > 0));
    CHECK(from_start.any_force() == (further > 0));
    CHECK(resumed.passes - first.passes <= from_start.passes + 1);
    if (further > 0) CHECK(resumed.passes - first.passes < from_start.passes);
  }
}

TEST_CASE("a search that does not settle where it goes on begins anew without contact forces") {
  const Squares squares(true);
  const std::vector<std::int32_t> none;
  const BeforeContact before{squares.reference, none, {}, 0.0};
  const double off = 1e-3;  // m, a hundred tolerances
  const auto anew = std::make_shared<bool>(false);
  Collision collision(squares.airway, squares.reference, std::make_unique<HeraldingMethod>(anew), {}, {},
                      std::make_unique<CarriedSolver>(squares, off, anew));
  Points x;
  const Contacts first = collision.solve(squares.at({0, 0, 0, 0, -0.5, -0.5, -0.5, -0.5}), 1.0, before, {}, x);
  REQUIRE(first.passes == 1);
  REQUIRE(std::exchange(*anew, false));
  const Contacts second = collision.solve(squares.at({0, 0, 0, 0, -0.4, -0.4, -0.4, -0.4}), 1.0, before, first, x);
  CHECK(second.passes == 1 + 10 + 1);
  CHECK(second.converged);
  CHECK(x.col(2).tail(4).cwiseAbs().maxCoeff() < 1e-5);
  CHECK(second.force.sum() == approx(1.6));
}

TEST_CASE("passes that swing between two shapes are linearised between them") {
  const Squares squares(false);
  const Points x_free = squares.at({-1, -1, -1, -1, -0.3, 1, 1, 1});
  Collision collision(squares.airway, squares.reference, std::make_unique<SwingingMethod>(), {}, {},
                      std::make_unique<RecordingSolver>(squares, std::make_shared<RecordingSolver::Record>()));
  Points x;
  const std::vector<std::int32_t> none;
  const double depth = 1;  // m, for the constraint's own depth to count
  const Contacts contacts = collision.solve(x_free, 1.0, {squares.reference, none, {}, depth}, {}, x);
  CHECK(contacts.converged);
  CHECK(contacts.passes > 6);
  CHECK(contacts.passes < 12);
  CHECK(std::abs(x(4, 2)) < 1e-9);
  CHECK(contacts.force.sum() == approx(0.3));
}

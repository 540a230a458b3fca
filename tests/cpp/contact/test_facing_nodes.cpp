#include <doctest/doctest.h>

#include "../approx.hpp"
#include "plica/contact/collision.hpp"
#include "plica/core/error.hpp"

using namespace plica;

namespace {

/// Two squares of two triangles each that face each other along z, a unit apart, the upper one first or last of
/// the surfaces; each node is held by a spring of 1 N/m in every direction.
struct Springs {
  Points reference = Points(8, 3);
  Airway airway;
  BlockMatrix stiffness{pattern()};
  Supports supports{8};
  std::unique_ptr<const LinearSolver> solver;

  explicit Springs(bool upper_first = false) {
    for (int k = 0; k < 8; ++k) {
      reference.row(k) << k % 2, k / 2 % 2, k / 4;
      for (int c = 0; c < 3; ++c) stiffness.block(k)[4 * c] = 1.0;
    }
    Triangles lower(2, 3), upper(2, 3);
    lower << 0, 1, 3, 0, 3, 2;
    upper << 4, 7, 5, 4, 6, 7;
    airway = upper_first ? matched_airway(reference, upper, lower, Vector3::UnitZ())
                         : matched_airway(reference, lower, upper, Vector3::UnitZ());
    solver = LinearSolver::make(stiffness, {1e-13, LinearSolver::ConjugateGradients{100}});
  }
  static Pattern pattern() {
    auto made = std::make_shared<NodePattern>();
    for (int k = 0; k <= 8; ++k) made->row_start.push_back(k);
    for (int k = 0; k < 8; ++k) made->column.push_back(k);
    return made;
  }
  Points at(const std::array<double, 8>& heights) const {
    Points x = reference;
    for (int k = 0; k < 8; ++k) x(k, 2) = heights[static_cast<std::size_t>(k)];
    return x;
  }
  Collision collision(int max_passes, const Enforcement& enforcement = Multipliers{},
                      std::optional<Friction> friction = {}) const {
    return Collision(airway, reference, contact_method(enforcement), friction, {1e-5, max_passes},
                     condensed_solver(*solver, supports, Indices::LinSpaced(8, 0, 7)));
  }
};

const std::vector<std::int32_t> nothing_closed;

/// Bent towards each other so that passes between the surfaces need several.
Points bent_springs(const Springs& springs) { return springs.at({0, 0, 0.4, 0, -0.3, -0.3, -0.7, -0.3}); }

}  // namespace

TEST_CASE(
    "facing nodes have their gap along the direction in which they face, and may stay as deep as they were") {
  for (const bool upper_first : {false, true}) {
    CAPTURE(upper_first);
    const Springs springs(upper_first);
    const Detector detector(springs.airway, springs.reference);
    const FacingNodes facing(detector, springs.reference);
    CHECK_FALSE(facing.empty());
    const Points &rest = springs.reference, x = springs.at({0, 0.2, 0, 0, 1, -0.1, -0.05, 1});
    const std::vector<std::int32_t> slaves = facing.closer(x, rest, 0.0);
    CHECK(slaves == (upper_first ? std::vector<std::int32_t>{5, 6} : std::vector<std::int32_t>{1, 2}));
    CHECK(facing.closer(x, rest, 0.1).size() == 1);
    CHECK(facing.closer(x, x, 0.0).empty());
    CHECK(facing.deepest(x) == approx(-0.3));
    CHECK(facing.deepest(rest) == 0);
    const Constraint constraint = facing.at(slaves[0], rest);
    CHECK(constraint.key == slaves[0]);
    CHECK(constraint.gap(x) == approx(-0.3));
    CHECK(constraint.gap(rest) == approx(1.0));
    CHECK(constraint.normal == Vector3(0, 0, upper_first ? 1 : -1));
    CHECK(facing.at(slaves[0], x).gap(x) == approx(0).scale(1));
  }
}

TEST_CASE("an airway that is not matched, or is cut anew, has no facing nodes") {
  Springs springs;
  springs.airway.facing.setZero();
  CHECK(FacingNodes(Detector(springs.airway, springs.reference), springs.reference).empty());
  springs = Springs();
  springs.airway.renewed = [](const Points&, const ContactSurface&, const ContactSurface&, double) {
    return Tets();
  };
  CHECK(FacingNodes(Detector(springs.airway, springs.reference), springs.reference).empty());
}

TEST_CASE("where passes fail facing nodes are held: each pair of springs meets halfway") {
  const Springs springs;
  const Points x_free = bent_springs(springs);
  const BeforeContact before{springs.reference, nothing_closed, {}, 0.0};
  Points x;
  Collision failing = springs.collision(1);
  CHECK(failing.facing() == nullptr);
  CHECK_THROWS_WITH_AS(failing.solve(x_free, 1.0, before, {}, x), doctest::Contains("after 1 passes"),
                       SolveFailed);

  Collision held = springs.collision(1);
  held.hold_facing(springs.reference, false);
  const Contacts contacts = held.solve(x_free, 1.0, before, {}, x);
  CHECK(contacts.facing);
  CHECK(contacts.converged);
  CHECK(contacts.passes > 1);
  for (int k = 0; k < 4; ++k) {
    const double overlap = x_free(k, 2) - x_free(k + 4, 2);
    CHECK(overlap > 0);
    CHECK(x(k, 2) == approx(x_free(k, 2) - 0.5 * overlap));
    CHECK(x(k + 4, 2) == approx(x_free(k + 4, 2) + 0.5 * overlap));
    CHECK(contacts.force_of(k) == approx(0.5 * overlap));
    CHECK((x.row(k) - x_free.row(k)).head<2>().norm() < 1e-12);
  }
  // The rest of the step is of facing nodes, too; drawn apart, nothing is held.
  Points other = x_free;
  other.col(2).tail(4).array() += 2;
  const Contacts later = held.solve(other, 1.0, before, contacts, x);
  CHECK(later.facing);
  CHECK_FALSE(later.any_force());
  CHECK(x == other);
  // The next step begins with passes again.
  CHECK_FALSE(held.solve(other, 1.0, before, {}, x).facing);
}

/// Multipliers whose passes see no contact.
class BlindMethod final : public ContactMethod {
 public:
  bool exact() const override { return true; }
  std::unique_ptr<ConstraintKind> kind(Detector&, const FaceMethod&) const override {
    return std::make_unique<Nothing>();
  }

 private:
  struct Nothing final : ConstraintKind {
    void update(const Points&) override {}
    std::vector<std::int32_t> violated(const Points&, double, const ContactSurface&, double) override {
      return {};
    }
    bool knows(std::int32_t) const override { return true; }
    Constraint at(std::int32_t, const Points&, double) override { return {}; }
    std::vector<PressedNode> pressed(const ContactSurface&, const Contact&, const Points&) override { return {}; }
    Vector pressure(const Contact&, const Points&) override { return {}; }
  };
};

TEST_CASE("passes that lead one surface through the other have failed, of mirror images") {
  const Springs springs;
  const Points through = springs.at({0, 0.2, 0, 0, 1, -0.1, 1, 1});
  const BeforeContact before{springs.reference, nothing_closed, {}, 0.0};
  for (const bool images : {false, true}) {
    CAPTURE(images);
    Collision collision(springs.airway, springs.reference, std::make_unique<BlindMethod>(), {}, {},
                        condensed_solver(*springs.solver, springs.supports, Indices::LinSpaced(8, 0, 7)));
    collision.hold_facing(springs.reference, images);
    Points x;
    const Contacts contacts = collision.solve(through, 1.0, before, {}, x);
    CHECK(contacts.facing == images);
    if (!contacts.facing) continue;
    CHECK(x(1, 2) == approx(0.05));
    CHECK(x(5, 2) == approx(0.05));
    CHECK(contacts.force.size() == 1);
    CHECK(contacts.force[0] == approx(0.15));
  }
}

TEST_CASE("nodes that begin behind each other are held as deep, and may part") {
  const Springs springs;
  Collision collision = springs.collision(1);
  collision.hold_facing(springs.reference, true);
  const Points behind = springs.at({0, 0.2, 0, 0, 1, -0.1, 1, 1}),
               deeper = springs.at({0, 0.3, 0, 0, 1, -0.2, 1, 1}),
               parting = springs.at({0, 0.1, 0, 0, 1, -0.05, 1, 1});
  const BeforeContact before{behind, nothing_closed, {}, 0.3};
  Points x;
  const Contacts held = collision.solve(deeper, 1.0, before, {}, x);
  CHECK(held.facing);
  CHECK(x(1, 2) - x(5, 2) == approx(0.3));
  CHECK(held.force.sum() == approx(0.1));
  CHECK_FALSE(collision.solve(parting, 1.0, before, held, x).any_force());
}

TEST_CASE("where passes settle facing nodes are not asked") {
  const Springs springs;
  const BeforeContact before{springs.reference, nothing_closed, {}, 0.0};
  Points x, x_held;
  Collision usual = springs.collision(200), held = springs.collision(200);
  held.hold_facing(springs.reference, false);
  const Contacts one = usual.solve(bent_springs(springs), 1.0, before, {}, x),
                 other = held.solve(bent_springs(springs), 1.0, before, {}, x_held);
  CHECK_FALSE(other.facing);
  CHECK(x_held == x);
  CHECK(other.force == one.force);
}

TEST_CASE("methods that are not exact, and friction, have no facing nodes") {
  const Springs springs;
  Collision penalty = springs.collision(1, Penalty{}), rough = springs.collision(1, Multipliers{}, Friction{0.3});
  for (Collision* collision : {&penalty, &rough}) {
    collision->hold_facing(springs.reference, false);
    CHECK(collision->facing() == nullptr);
  }
}

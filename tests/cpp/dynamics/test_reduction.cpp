#include <doctest/doctest.h>

#include <algorithm>

#include "plica/core/error.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

/// The columns of the identity of what is free: nothing is left out.
Eigen::MatrixXd every_displacement(const Scene& scene) {
  std::vector<std::ptrdiff_t> free;
  for (std::ptrdiff_t i = 0; i < scene.supports.size(); ++i)
    if (!scene.supports.fixed(i)) free.push_back(i);
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(scene.supports.size(), static_cast<std::ptrdiff_t>(free.size()));
  for (std::size_t j = 0; j < free.size(); ++j) basis(free[j], static_cast<std::ptrdiff_t>(j)) = 1.0;
  return basis;
}

Scene reduced(Scene scene, Eigen::MatrixXd basis, double reach = 1.0) {
  scene.reduction = Reduction{std::move(basis), reach, 1};
  return scene;
}

/// Of the part of a symmetric scene, each with its mirror images.
Eigen::MatrixXd every_symmetric_displacement(const Scene& scene, Symmetry symmetry) {
  const MirrorImages images(scene.mesh, symmetry);
  std::vector<Vector> columns;
  for (std::ptrdiff_t i = 0; i < 3 * images.nodes().size(); ++i) {
    const std::int32_t node = images.nodes()[i / 3];
    const auto axis = static_cast<std::size_t>(i % 3);
    if (axis < images.planes() && images.partner(axis, node) == node) continue;
    if (scene.supports.fixed(3 * static_cast<std::ptrdiff_t>(node) + i % 3)) continue;
    columns.push_back(images.spread(Vector::Unit(3 * images.nodes().size(), i)));
  }
  Eigen::MatrixXd basis(scene.supports.size(), static_cast<std::ptrdiff_t>(columns.size()));
  for (std::size_t j = 0; j < columns.size(); ++j) basis.col(static_cast<std::ptrdiff_t>(j)) = columns[j];
  return basis;
}

double relative(const Vector& a, const Vector& b) { return (a - b).norm() / b.norm(); }

/// The folds alone: what lies above and below them is held, so that the dense algebra of all modes takes a moment.
Scene small_larynx() {
  Scene scene = scenes::small_larynx();
  for (std::int32_t i = 0; i < scene.mesh.node_count(); ++i)
    if (std::abs(scene.mesh.points(i, 2)) > 2e-3) {
      scene.supports.fix(i);
      scene.velocity->row(i).setZero();
    }
  return scene;
}

/// The same where nothing moves in the plane between the folds.
Scene symmetric_larynx() {
  Scene scene = small_larynx();
  for (std::ptrdiff_t i = 0; i < scene.mesh.node_count(); ++i)
    if (scene.mesh.points(i, 0) == 0) scene.velocity->row(i).setZero();
  return scene;
}

/// The lowest modes of the small larynx.
Eigen::MatrixXd lowest_modes(int count) {
  static const Eigen::MatrixXd shapes = [] {
    const Scene scene = small_larynx();
    const Simulation all(reduced(scene, every_displacement(scene)), options(HilberHughesTaylor{}, 50e-6));
    return Eigen::MatrixXd(all.reduced()->motion().shapes());
  }();
  return shapes.leftCols(count);
}

}  // namespace

TEST_CASE("a basis of all displacements gives the motion of the scene, its air and its collision") {
  for (const bool thesis : {true, false}) {
    Scene scene = small_larynx();
    scene.contact->options.tolerance = 1e-10;  // what contact leaves open differs in its last digits
    if (!thesis) {
      scene.airflow->flow.model = ViscousSlit{};
      scene.airflow->flow.area = CutSections{12};
    }
    Simulation full(scene, options(HilberHughesTaylor{}, 50e-6)),
        same(reduced(scene, every_displacement(scene)), options(HilberHughesTaylor{}, 50e-6));
    int rows = 0;
    for (int k = 0; k < 40; ++k) {
      full.advance();
      same.advance();
      const StepRecord &a = same.record(), &b = full.record();
      CHECK(relative(same.displacement(), full.displacement()) < 1e-8);
      CHECK(relative(a.flow->state.area, b.flow->state.area) < 1e-8);
      CHECK(a.contact->rows == b.contact->rows);
      CHECK((a.contact->force_first - b.contact->force_first).norm() <
            1e-6 * b.contact->force_first.norm() + 1e-12);
      CHECK(a.strains.strain == doctest::Approx(b.strains.strain).epsilon(1e-7));
      rows += b.contact->rows;
    }
    CHECK(rows > 0);
    CHECK(relative(same.velocity(), full.velocity()) < 1e-7);
    CHECK(relative(same.coronal(Side::left).reshaped(), full.coronal(Side::left).reshaped()) < 1e-9);
    const Ledger &a = same.state().ledger, &b = full.state().ledger;
    for (const auto term : {&Ledger::kinetic, &Ledger::elastic, &Ledger::flow_work, &Ledger::contact_work,
                            &Ledger::viscous_loss, &Ledger::numerical_loss})
      CHECK(std::abs(a.*term - b.*term) < 1e-7 * b.initial);
  }
}

TEST_CASE("the ledger of a reduced motion closes, and its folds do not pass through each other") {
  const Scene scene = small_larynx();
  Simulation simulation(reduced(scene, lowest_modes(60)), options(HilberHughesTaylor{}, 50e-6));
  double off = 0, deepest = 0;
  int rows = 0;
  for (int k = 0; k < 80; ++k) {
    simulation.advance();
    off = std::max(off, std::abs(simulation.state().ledger.error()));
    deepest = std::min(deepest, simulation.record().contact->deepest_gap);
    rows += simulation.record().contact->rows;
  }
  const Ledger& ledger = simulation.state().ledger;
  CHECK(simulation.reduced()->motion().size() == 60);
  CHECK(rows > 0);
  CHECK(std::abs(ledger.flow_work) > 1e-4 * ledger.initial);
  CHECK(off < 1e-11 * ledger.initial);
  CHECK(deepest > -1e-5 * simulation.collision()->detector().mean_edge());
}

TEST_CASE("a symmetric basis of all displacements gives the motion of the whole through its collisions") {
  for (const bool thesis : {true, false})
    for (const Symmetry symmetry : {Symmetry::half, Symmetry::quarter}) {
      Scene scene = symmetric_larynx();
      scene.contact->options.tolerance = 1e-10;
      if (!thesis) {
        scene.airflow->flow.model = ViscousSlit{};
        scene.airflow->flow.area = CutSections{12};
        scene.airflow->coupling = Iterated{1e-9};
      }
      // What sweeps leave to their tolerance differs: forces are found in another way.
      const double close = thesis ? 1e-6 : 1e-8;
      Simulation full(scene, options(HilberHughesTaylor{}, 50e-6));
      Scene symmetric = reduced(scene, every_symmetric_displacement(scene, symmetry));
      symmetric.symmetry = symmetry;
      Simulation part(symmetric, options(HilberHughesTaylor{}, 50e-6));
      CHECK(part.reduced()->motion().size() == symmetric.reduction->basis.cols());
      int rows = 0;
      for (int k = 0; k < 40; ++k) {
        full.advance();
        part.advance();
        const StepRecord &a = part.record(), &b = full.record();
        CHECK(relative(part.displacement(), full.displacement()) < close);
        CHECK(relative(a.flow->state.area, b.flow->state.area) < close);
        CHECK(a.flow->state.stopped == b.flow->state.stopped);
        CHECK((a.contact->rows > 0) == (b.contact->rows > 0));
        CHECK((a.contact->force_first - b.contact->force_first).norm() <
              50 * close * b.contact->force_first.norm() + 1e-12);
        CHECK(a.contact->area == doctest::Approx(b.contact->area).epsilon(1e-6));
        CHECK(a.contact->length == doctest::Approx(b.contact->length).epsilon(1e-6));
        CHECK(a.contact->peak_pressure == doctest::Approx(b.contact->peak_pressure).epsilon(1e-4));
        CHECK(a.contact->deepest_gap > -1e-9 * full.collision()->detector().mean_edge());
        rows += b.contact->rows;
      }
      CHECK(rows > 0);
      CHECK(relative(part.velocity(), full.velocity()) < 1e-6);
      CHECK(relative(part.coronal(Side::right).reshaped(), full.coronal(Side::right).reshaped()) < 1e-8);
      const Vector force = full.contact_force(), pressure = full.contact_pressure();
      CHECK((part.contact_force() - force).norm() <= 1e-5 * force.norm() + 1e-12);
      CHECK((part.contact_pressure() - pressure).norm() <= 1e-5 * pressure.norm() + 1e-9);
      const Ledger &a = part.state().ledger, &b = full.state().ledger;
      for (const auto term : {&Ledger::kinetic, &Ledger::elastic, &Ledger::flow_work, &Ledger::contact_work,
                              &Ledger::viscous_loss, &Ledger::numerical_loss})
        CHECK(std::abs(a.*term - b.*term) < 1e-6 * b.initial);
      CHECK(std::abs(a.error()) < 1e-11 * b.initial);
    }
}

TEST_CASE("a restored motion of a symmetric reduction goes on as if it had not stopped") {
  Scene scene = symmetric_larynx();
  scene = reduced(scene, every_symmetric_displacement(scene, Symmetry::quarter));
  scene.symmetry = Symmetry::quarter;
  scene.reduction->watch_every = 7;
  Simulation one(scene, options(HilberHughesTaylor{}, 50e-6)), other(scene, options(HilberHughesTaylor{}, 50e-6));
  int pressed = 0;
  for (int k = 0; k < 30; ++k) {
    one.advance();
    other.restore(one.state());
    pressed += one.contact_pressure().maxCoeff() > 0;
    CHECK(other.contact_pressure() == one.contact_pressure());
    CHECK(other.contact_force() == one.contact_force());
  }
  CHECK(pressed > 0);
  for (int k = 0; k < 10; ++k) one.advance(), other.advance();
  CHECK(other.state().displacement == one.state().displacement);
  CHECK(other.record().strains.largest == one.record().strains.largest);
  State wrong = one.state();
  wrong.closed = {100000};
  wrong.closed_force = Vector::Ones(1);
  CHECK_THROWS_WITH_AS(other.restore(wrong), doctest::Contains("closed constraint"), InvalidInput);
}

TEST_CASE("what a symmetric reduction cannot have is refused") {
  Scene scene = symmetric_larynx();
  scene = reduced(scene, every_symmetric_displacement(scene, Symmetry::half).leftCols(20));
  scene.symmetry = Symmetry::half;
  const auto build = [&](const Scene& given) { Simulation(given, options(HilberHughesTaylor{}, 50e-6)); };
  CHECK_NOTHROW(build(scene));
  Scene other = scene;
  other.contact->enforcement = Penalty{};
  CHECK_THROWS_WITH_AS(build(other), doctest::Contains("must be by multipliers"), InvalidInput);
  other.contact->enforcement = Multipliers{Automatic{}, Weighted{}};
  CHECK_THROWS_WITH_AS(build(other), doctest::Contains("end of the step"), InvalidInput);
  other = scene;
  other.contact->friction = Friction{0.3};
  CHECK_THROWS_WITH_AS(build(other), doctest::Contains("friction must be left out"), InvalidInput);
  other = scene;
  other.reduction->basis(3 * static_cast<std::ptrdiff_t>(scene.mesh.node_count() / 2), 0) += 0.1;
  CHECK_THROWS_WITH_AS(build(other), doctest::Contains("vector 0 of the reduction's basis at node"), InvalidInput);
}

TEST_CASE("loads and gravity act on a reduced motion as on all nodes") {
  Scene scene = scenes::held_block(0.3, 1.0);
  scene.loads = {{"x_max", {0, -40, 10}, 80.0, 0.4}};
  scene.gravity = Vector3(0, 0, -9.81);
  const Vector force = Vector::Constant(scene.supports.size(), 1e-4);
  Simulation full(scene, options(Newmark{}, 1e-4)),
      same(reduced(scene, every_displacement(scene)), options(Newmark{}, 1e-4));
  for (int k = 0; k < 30; ++k) {
    if (k == 10) full.set_external_force(force), same.set_external_force(force);
    full.advance();
    same.advance();
  }
  CHECK(relative(same.displacement(), full.displacement()) < 1e-9);
  CHECK(same.state().ledger.load_work == doctest::Approx(full.state().ledger.load_work).epsilon(1e-9));
}

TEST_CASE("a restored reduced motion goes on as if it had not stopped") {
  Scene scene = reduced(small_larynx(), lowest_modes(60));
  scene.reduction->watch_every = 7;
  Simulation one(scene, options(HilberHughesTaylor{}, 50e-6)), other(scene, options(HilberHughesTaylor{}, 50e-6));
  for (int k = 0; k < 30; ++k) one.advance();
  other.restore(one.state());
  CHECK(other.contact_pressure() == one.contact_pressure());
  for (int k = 0; k < 10; ++k) one.advance(), other.advance();
  CHECK(other.state().displacement == one.state().displacement);
  CHECK(other.record().strains.largest == one.record().strains.largest);
}

TEST_CASE("what cannot be reduced is refused") {
  const Scene scene = small_larynx();
  const Eigen::MatrixXd basis = lowest_modes(3);
  const auto build = [&](const Scene& given) { Simulation(given, options(HilberHughesTaylor{}, 50e-6)); };
  CHECK_THROWS_WITH_AS(build(reduced(scene, basis.topRows(9))),
                       doctest::Contains("rows of the basis = 9; must be 3 times the"), InvalidInput);
  CHECK_THROWS_WITH_AS(build(reduced(scene, 0 * basis)), doctest::Contains("moves nothing"), InvalidInput);
  CHECK_THROWS_WITH_AS(build(reduced(scene, basis, -1.0)), doctest::Contains("contact_reach = -1 m; must be > 0"),
                       InvalidInput);
  const Scene cubes = scenes::two_cubes(Multipliers{});  // half a millimetre apart
  CHECK_THROWS_WITH_AS(build(reduced(cubes, every_displacement(cubes), 1e-9)),
                       doctest::Contains("No face of the contact"), InvalidInput);
  Scene other = reduced(scene, basis);
  other.airflow->flow.load_shape = Airflow::CurrentShape{};
  CHECK_THROWS_WITH_AS(build(other), doctest::Contains("load_shape"), InvalidInput);
  other = reduced(scene, basis);
  other.contact->enforcement = Nitsche{};
  CHECK_THROWS_WITH_AS(build(other), doctest::Contains("Nitsche"), InvalidInput);
  other.contact->enforcement = Multipliers{};
  other.contact->surface_mass = SurfaceMass::redistributed;
  CHECK_THROWS_WITH_AS(build(other), doctest::Contains("surface_mass"), InvalidInput);
}

TEST_CASE("folds that meet beyond the reach of contact end the run") {
  const Scene scene = small_larynx();
  const Eigen::MatrixXd modes = lowest_modes(60);
  Simulation simulation(reduced(scene, modes, 0.2e-3), options(HilberHughesTaylor{}, 50e-6));
  const Points rest = scene.mesh.points, mirrored = rest * Vector3(-1, 1, 1).asDiagonal();
  CHECK_NOTHROW(simulation.reduced()->contact()->require_open_beyond(rest));
  CHECK_THROWS_AS(simulation.reduced()->contact()->require_open_beyond(mirrored), SolveFailed);
  const auto collide = [&] {
    for (int k = 0; k < 80; ++k) simulation.advance();
  };
  CHECK_THROWS_WITH_AS(collide(), doctest::Contains("Raise contact_reach"), SolveFailed);
}

#include <doctest/doctest.h>

#include "../approx.hpp"
#include "plica/core/error.hpp"
#include "reduced_scenes.hpp"

using namespace plica;
using namespace scenes;

TEST_CASE("a symmetric basis of all displacements gives the motion of the whole through its collisions") {
  for (const bool thesis : {true, false})
    for (const Symmetry symmetry : {Symmetry::half, Symmetry::quarter}) {
      Scene scene = symmetric_folds();
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
        CHECK(a.contact->area == approx(b.contact->area).epsilon(1e-6));
        CHECK(a.contact->length == approx(b.contact->length).epsilon(1e-6));
        CHECK(a.contact->peak_pressure == approx(b.contact->peak_pressure).epsilon(1e-4));
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

TEST_CASE("mirror images collide without airflow as well, and positions that are not finite are refused") {
  Scene scene = symmetric_folds();
  scene.airflow.reset();
  scene.contact->options.tolerance = 1e-10;
  Simulation full(scene, options(HilberHughesTaylor{}, 50e-6));
  Scene symmetric = reduced(scene, every_symmetric_displacement(scene, Symmetry::quarter));
  symmetric.symmetry = Symmetry::quarter;
  symmetric.reduction->watch_every = 100;  // contact alone looks at the steps
  Simulation part(symmetric, options(HilberHughesTaylor{}, 50e-6));
  int rows = 0;
  for (int k = 0; k < 40; ++k) {
    full.advance();
    part.advance();
    CHECK(relative(part.displacement(), full.displacement()) < 5e-6);  // normals of pairs turn, the plane does not
    rows += part.record().contact->rows;
  }
  CHECK(rows > 0);
  Vector force = Vector::Constant(scene.mesh.points.size(), 0.0);
  for (std::ptrdiff_t i = 0; i < scene.mesh.node_count(); ++i)
    force[3 * i] = scene.mesh.points(i, 0) > 0 ? 1e308 : scene.mesh.points(i, 0) < 0 ? -1e308 : 0.0;
  part.set_external_force(force);
  const auto go_on = [&] {
    for (int k = 0; k < 5; ++k) part.advance();
  };
  CHECK_THROWS_WITH_AS(go_on(), doctest::Contains("positions are not finite"), SolveFailed);
}

TEST_CASE("a restored motion of a symmetric reduction goes on as if it had not stopped") {
  Scene scene = symmetric_folds();
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
  State kicked = one.state();
  kicked.velocity *= 1.5;
  CHECK_THROWS_WITH_AS(other.restore(kicked), doctest::Contains("from K v = 0.333"), InvalidInput);
  other.restore(other.renewed(kicked));
  other.restore(one.state());
  State wrong = one.state();
  wrong.closed = {100000};
  wrong.closed_force = Vector::Ones(1);
  CHECK_THROWS_WITH_AS(other.restore(wrong), doctest::Contains("closed constraint"), InvalidInput);
}

TEST_CASE("what a symmetric reduction cannot have is refused") {
  Scene scene = symmetric_folds();
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
  other.reduction->basis(3 * static_cast<std::ptrdiff_t>(scene.mesh.node_count() / 2), 0) += 0.1;
  CHECK_THROWS_WITH_AS(build(other), doctest::Contains("vector 0 of the reduction's basis at node"), InvalidInput);
}

TEST_CASE("mirror images do not slide past each other, so that friction does nothing") {
  Scene scene = symmetric_folds();
  scene = reduced(scene, every_symmetric_displacement(scene, Symmetry::quarter));
  scene.symmetry = Symmetry::quarter;
  Simulation smooth(scene, options(HilberHughesTaylor{}, 50e-6));
  scene.contact->friction = Friction{0.3};
  Simulation rough(scene, options(HilberHughesTaylor{}, 50e-6));
  int rows = 0;
  for (int k = 0; k < 20; ++k) {
    smooth.advance();
    rough.advance();
    rows += smooth.record().contact->rows;
    CHECK(rough.state().displacement == smooth.state().displacement);
    CHECK(rough.record().contact->friction_loss == 0);
  }
  CHECK(rows > 0);
}

TEST_CASE("gaps are closed to the tolerance, and a step that leaves more open says so") {
  // What keeps equal rows solvable, 1e-9 of the compliance, is the least that can be left.
  for (const double tolerance : {1e-5, 1e-16}) {
    Scene scene = symmetric_folds();
    scene.contact->options.tolerance = tolerance;
    scene = reduced(scene, every_symmetric_displacement(scene, Symmetry::quarter));
    scene.symmetry = Symmetry::quarter;
    Simulation simulation(scene, options(HilberHughesTaylor{}, 50e-6));
    const double most = 2 * tolerance * simulation.collision()->detector().mean_edge();
    int pressed = 0, open = 0;
    for (int k = 0; k < 40; ++k) {
      simulation.advance();
      const ContactRecord& contact = *simulation.record().contact;
      CHECK(contact.gap_error == -contact.deepest_gap);
      CHECK(contact.gap_error >= 0);
      CHECK(contact.converged == (contact.gap_error <= most));
      pressed += contact.rows > 0;
      open += !contact.converged;
    }
    CHECK(pressed > 3);
    CHECK((open > 0) == (tolerance < 1e-10));
  }
}

#include <doctest/doctest.h>

#include <algorithm>

#include "../approx.hpp"
#include "plica/core/error.hpp"
#include "plica/dynamics/last_basis.hpp"
#include "reduced_scenes.hpp"

using namespace plica;
using namespace scenes;

namespace {

/// The lowest modes of the small larynx.
Eigen::MatrixXd lowest_modes(int count) {
  static const Eigen::MatrixXd shapes = [] {
    const Scene scene = larynx_folds();
    const Simulation all(reduced(scene, every_displacement(scene)), options(HilberHughesTaylor{}, 50e-6));
    return Eigen::MatrixXd(all.reduced()->motion().shapes());
  }();
  return shapes.leftCols(count);
}

}  // namespace

TEST_CASE("a basis of all displacements gives the motion of the scene, its air and its collision") {
  for (const bool thesis : {true, false}) {
    Scene scene = larynx_folds();
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
      CHECK(a.strains.strain == approx(b.strains.strain).epsilon(1e-7));
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

TEST_CASE("a reduced motion has the couplings that do not iterate, too") {
  for (const Coupling& coupling : {Coupling(Lagged{}), Coupling(Extrapolated{})}) {
    Scene scene = larynx_folds();
    scene.contact->options.tolerance = 1e-10;
    scene.airflow->flow.model = ViscousSlit{};
    scene.airflow->flow.area = CutSections{12};
    scene.airflow->coupling = coupling;
    Simulation full(scene, options(HilberHughesTaylor{}, 50e-6)),
        same(reduced(scene, every_displacement(scene)), options(HilberHughesTaylor{}, 50e-6));
    for (int k = 0; k < 20; ++k) {
      full.advance();
      same.advance();
      CHECK(relative(same.displacement(), full.displacement()) < 1e-8);
      CHECK(relative(same.record().flow->state.area, full.record().flow->state.area) < 1e-8);
    }
  }
}

TEST_CASE("the ledger of a reduced motion closes, and its folds do not pass through each other") {
  const Scene scene = larynx_folds();
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
  CHECK(same.state().ledger.load_work == approx(full.state().ledger.load_work).epsilon(1e-9));
}

TEST_CASE("a restored reduced motion goes on as if it had not stopped") {
  Scene scene = reduced(larynx_folds(), lowest_modes(60));
  scene.reduction->watch_every = 7;
  Simulation one(scene, options(HilberHughesTaylor{}, 50e-6)), other(scene, options(HilberHughesTaylor{}, 50e-6));
  for (int k = 0; k < 30; ++k) one.advance();
  other.restore(one.state());
  CHECK(other.contact_pressure() == one.contact_pressure());
  for (int k = 0; k < 10; ++k) one.advance(), other.advance();
  CHECK(other.state().displacement == one.state().displacement);
  CHECK(other.record().strains.largest == one.record().strains.largest);
  State kicked = one.state();
  kicked.velocity *= 1.5;
  CHECK_THROWS_WITH_AS(other.restore(kicked), doctest::Contains("from K v = 0.333"), InvalidInput);
  other.restore(other.renewed(kicked));
  CHECK(other.state().velocity == kicked.velocity);
  kicked.displacement *= 1.1;
  CHECK_THROWS_WITH_AS(other.renewed(kicked), doctest::Contains("displacement of a state with contact"),
                       InvalidInput);
}

TEST_CASE("a scene that is made after another has the bits of one that is made alone, whatever changed") {
  const Scene scene = reduced(larynx_folds(), lowest_modes(20));
  std::vector<Scene> scenes(6, scene);  // the second is the same again
  scenes[2].tissue.materials[0].viscosity += 1;
  scenes[3].tissue.materials[0].density *= 1.1;
  scenes[4].reduction->basis.row(scene.supports.size() / 2).array() += scene.reduction->basis(0, 0) + 1e-3;
  for (std::int32_t i = 0; i < scene.mesh.node_count(); ++i)
    if (scene.mesh.points(i, 2) > 0) scenes[5].supports.fix(i);
  const auto last = std::make_shared<LastBasis>();
  std::vector<Vector> found;
  for (Scene& one : scenes) {
    Simulation alone(one, options(HilberHughesTaylor{}, 50e-6));
    one.reduction->last = last;
    Simulation after(one, options(HilberHughesTaylor{}, 50e-6));
    for (int k = 0; k < 5; ++k) alone.advance(), after.advance();
    CHECK(after.state().displacement == alone.state().displacement);
    CHECK(after.displacement() == alone.displacement());
    found.push_back(alone.displacement());
  }
  CHECK(found[1] == found[0]);
  for (std::size_t k = 2; k < found.size(); ++k) CHECK(found[k] != found[0]);  // another basis would be seen
}

TEST_CASE("what cannot be reduced is refused") {
  const Scene scene = larynx_folds();
  const Eigen::MatrixXd basis = lowest_modes(3);
  const auto build = [&](const Scene& given) { Simulation(given, options(HilberHughesTaylor{}, 50e-6)); };
  CHECK_THROWS_WITH_AS(build(reduced(scene, basis.topRows(9))),
                       doctest::Contains("rows of the basis = 9; must be 3 times the"), InvalidInput);
  CHECK_THROWS_WITH_AS(build(reduced(scene, 0 * basis)), doctest::Contains("moves nothing"), InvalidInput);
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

TEST_CASE("what contact finds does not depend on where it was looked for") {
  // A restored simulation looks everywhere, one that goes on only where surfaces are near each other.
  for (const Enforcement& enforcement : {Enforcement(Multipliers{}), Enforcement(Penalty{}),
                                         Enforcement(VolumePenalty{}), Enforcement(Augmented{})}) {
    Scene scene = reduced(larynx_folds(), lowest_modes(60));
    scene.contact->enforcement = enforcement;
    Simulation one(scene, options(HilberHughesTaylor{}, 50e-6)),
        other(scene, options(HilberHughesTaylor{}, 50e-6));
    int rows = 0;
    for (int k = 0; k < 80; ++k) {
      other.restore(one.state());
      one.advance();
      other.advance();
      rows += one.record().contact->rows;
      CHECK(other.state().displacement == one.state().displacement);
      CHECK(other.state().closed == one.state().closed);
      CHECK(other.record().contact->deepest_gap == one.record().contact->deepest_gap);
      CHECK(other.contact_pressure() == one.contact_pressure());
    }
    CHECK(rows > 0);
  }
}

TEST_CASE(
    "a damping ratio damps tissue without viscosity, and a run that is continued goes on with it, bit for bit") {
  Scene scene = reduced(larynx_folds(), lowest_modes(60));
  for (Material& material : scene.tissue.materials) material.viscosity = 0;
  Simulation undamped(scene, options(Newmark{}, 50e-6));
  scene.reduction->damping_ratio = 0.05;
  Simulation whole(scene, options(Newmark{}, 50e-6)), second(scene, options(Newmark{}, 50e-6));
  for (int i = 0; i < 20; ++i) {
    undamped.advance();
    whole.advance();
  }
  CHECK(whole.state().ledger.viscous_loss > 0);
  CHECK(undamped.state().ledger.viscous_loss == 0);
  second.restore(whole.state());
  for (int i = 0; i < 20; ++i) {
    whole.advance();
    second.advance();
  }
  CHECK(second.displacement() == whole.displacement());
  CHECK_THROWS_AS(second.restore(undamped.state()), InvalidInput);
}

TEST_CASE("surfaces that passed through each other where no contact was looked for end the run") {
  const Scene scene = larynx_folds();
  Simulation simulation(reduced(scene, lowest_modes(60)), options(HilberHughesTaylor{}, 50e-6));
  simulation.advance();
  const Points rest = scene.mesh.points, mirrored = rest * Vector3(-1, 1, 1).asDiagonal();
  State moved = simulation.state();
  CHECK_NOTHROW(simulation.reduced()->contact()->require_open_beyond(moved, rest));
  moved.displacement.setOnes();
  CHECK_THROWS_WITH_AS(simulation.reduced()->contact()->require_open_beyond(moved, mirrored),
                       doctest::Contains("passed through each other at node"), SolveFailed);
}

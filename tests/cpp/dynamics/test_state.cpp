#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>

#include "../approx.hpp"
#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

void check_equal(const State& a, const State& b) {
  CHECK(a.step == b.step);
  CHECK(a.displacement == b.displacement);
  CHECK(a.velocity == b.velocity);
  CHECK(a.acceleration == b.acceleration);
  CHECK(a.load == b.load);
  CHECK(a.contact_force == b.contact_force);
  CHECK(a.flow_load == b.flow_load);
  CHECK(a.elastic_force == b.elastic_force);
  CHECK(a.weighted_elastic_force == b.weighted_elastic_force);
  CHECK(a.viscous_force == b.viscous_force);
  CHECK(a.inertial_force == b.inertial_force);
  CHECK(a.stiffness_velocity == b.stiffness_velocity);
  CHECK(a.stiffness_acceleration == b.stiffness_acceleration);
  CHECK(a.viscosity_velocity == b.viscosity_velocity);
  CHECK(a.viscosity_acceleration == b.viscosity_acceleration);
  CHECK(a.past.accelerations == b.past.accelerations);
  CHECK(a.past.images == b.past.images);
  CHECK(a.closed == b.closed);
  CHECK(a.depth == b.depth);
  CHECK(a.air.flow_stopped == b.air.flow_stopped);
  CHECK(a.supplied_power == b.supplied_power);
  CHECK(a.viscous_power == b.viscous_power);
  CHECK(a.ledger.kinetic == b.ledger.kinetic);
  CHECK(a.ledger.elastic == b.ledger.elastic);
  CHECK(a.ledger.load_work == b.ledger.load_work);
  CHECK(a.ledger.flow_work == b.ledger.flow_work);
  CHECK(a.ledger.air_supplied_energy == b.ledger.air_supplied_energy);
  CHECK(a.ledger.air_viscous_energy == b.ledger.air_viscous_energy);
  CHECK(a.ledger.contact_work == b.ledger.contact_work);
  CHECK(a.ledger.viscous_loss == b.ledger.viscous_loss);
  CHECK(a.ledger.numerical_loss == b.ledger.numerical_loss);
  CHECK(a.ledger.initial == b.ledger.initial);
  const auto &s = a.first_signs.folded_tissue, &t = b.first_signs.folded_tissue;
  REQUIRE(s.has_value() == t.has_value());
  if (s) CHECK((s->step == t->step && s->count == t->count && s->cell == t->cell && s->place == t->place));
}

}  // namespace

TEST_CASE("a restored state continues to the last bit, flow and contact included") {
  const Simulation::Options o = options(HilberHughesTaylor{}, 1e-4, 1e-8);
  for (const ContactSolver& solver : {ContactSolver(Condensed{}), ContactSolver(Saddle{})}) {
    CAPTURE(std::string(name_of(solver)));
    Scene scene = scenes::small_larynx();
    scene.contact->enforcement = Multipliers{solver, EndOfStep{}};
    Simulation whole(scene, o), first(scene, o), second(scene, o);
    bool flowed = false;
    int touching_after = 0;
    for (int k = 0; k < 24; ++k) {
      whole.advance();
      flowed = flowed || whole.record().flow->state.flow > 0;
      if (k < 9) first.advance();
      if (k < 9 || whole.record().contact->rows == 0) continue;
      // From a state on the way, in a simulation that has been through more.
      second.restore(first.state());
      for (int l = 9; l <= k; ++l) second.advance();
      check_equal(whole.state(), second.state());
      ++touching_after;
    }
    CHECK(touching_after > 0);
    CHECK(flowed);
    second.restore(first.state());
    for (int k = 9; k < 24; ++k) second.advance();
    check_equal(whole.state(), second.state());
    CHECK(whole.record().flow->state.pressure == second.record().flow->state.pressure);
    CHECK(whole.record().iterations == second.record().iterations);
    CHECK(whole.contact_pressure() == second.contact_pressure());
  }
}

TEST_CASE("one thread and two give the same bits") {
  const Simulation::Options o = options(HilberHughesTaylor{}, 1e-4, 1e-8);
  for (const ContactSolver& solver : {ContactSolver(Condensed{}), ContactSolver(Saddle{})}) {
    CAPTURE(std::string(name_of(solver)));
    Scene scene = scenes::small_larynx();
    scene.contact->enforcement = Multipliers{solver, EndOfStep{}};
    Simulation one(scene, o), two(scene, o);
    for (int k = 0; k < 15; ++k) {
      set_threads(1);
      one.advance();
      set_threads(2);
      two.advance();
    }
    set_threads(1);
    check_equal(one.state(), two.state());
  }
}

TEST_CASE("what a scene lacks does not exist") {
  Simulation simulation(scenes::held_block(), options(HilberHughesTaylor{}, 1e-4));
  simulation.advance();
  CHECK(simulation.airflow() == nullptr);
  CHECK(simulation.collision() == nullptr);
  CHECK_FALSE(simulation.viscosity().has_value());
  CHECK_FALSE(simulation.record().flow.has_value());
  CHECK_FALSE(simulation.record().contact.has_value());
  CHECK(simulation.state().contact_force.size() == 0);
  CHECK(simulation.state().viscous_force.size() == 0);
  CHECK(simulation.state().closed.capacity() == 0);
  CHECK(simulation.times().detection + simulation.times().contact + simulation.times().load == 0.0);
  CHECK(simulation.contact_pressure().isZero(0));
}

TEST_CASE("contact pressure is zero before the first step and after a return to rest") {
  Simulation simulation(scenes::two_bars(4, Multipliers{}), options(HilberHughesTaylor{}, 1e-4));
  CHECK(simulation.contact_pressure().isZero(0));
  const State rest = simulation.state();
  simulation.advance();
  CHECK(simulation.contact_pressure().maxCoeff() > 0);
  simulation.restore(rest);
  CHECK(simulation.contact_pressure().isZero(0));
}

TEST_CASE("a force of the embedder's own accelerates as a load does") {
  Simulation simulation(scenes::tissue_scene(block_mesh({{0, 0, 0}, {0.01, 0.01, 0.01}, {1, 1, 1}}), 0.3, 0.0),
                        options(Newmark{}, 1e-4));
  Vector force = simulation.mass() * Vector::Constant(24, 3.0);  // 3 m/s^2 in every direction
  simulation.set_external_force(force);
  simulation.advance();
  simulation.advance();
  CHECK((simulation.state().acceleration.array() - 3.0).abs().maxCoeff() < 1e-9);
  CHECK_THROWS_AS(simulation.set_external_force(Vector::Zero(7)), InvalidInput);
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
    Vector broken = force;
    broken[3 * 5 + 2] = value;
    CHECK_THROWS_WITH_AS(simulation.set_external_force(broken),
                         doctest::Contains("Simulation: external force along z on node 5 = "), InvalidInput);
  }
}

TEST_CASE("a force of the embedder's own counts at t + (1 + alpha) h, as a load of the scene does") {
  const double h = 1e-4, frequency = 150.0;
  for (const double alpha : {-0.3, 0.0}) {
    Scene scene = scenes::held_block();
    Simulation driven(scene, options(HilberHughesTaylor{alpha}, h));
    scene.loads = {{"x_max", {0, 200.0, 0}, frequency, 0.0}};
    Simulation loaded(scene, options(HilberHughesTaylor{alpha}, h));
    const Vector amplitude = loaded.state().load;  // cos 0 = 1
    for (int k = 0; k < 10; ++k) {
      const double t = driven.time() + (1 + alpha) * h;
      driven.set_external_force(std::cos(2 * M_PI * frequency * t) * amplitude);
      driven.advance();
      loaded.advance();
      CHECK(driven.state().load.isApprox(loaded.state().load, 1e-12));
    }
    CHECK((driven.state().load - amplitude).norm() > 0.1 * amplitude.norm());
  }
}

TEST_CASE("scenes that do not fit are refused") {
  const Simulation::Options o = options(HilberHughesTaylor{}, 1e-4);
  Scene scene = scenes::held_block();
  scene.velocity = Points::Zero(3, 3);
  CHECK_THROWS_AS(Simulation(scene, o), InvalidInput);
  scene = scenes::held_block();
  scene.displacement = Points::Constant(scene.mesh.node_count(), 3, std::numeric_limits<double>::quiet_NaN());
  CHECK_THROWS_AS(Simulation(scene, o), InvalidInput);
  scene = scenes::held_block();
  scene.supports = Supports(2);
  CHECK_THROWS_AS(Simulation(scene, o), InvalidInput);
  scene = scenes::held_block();
  scene.loads = {{"no such surface", {1, 0, 0}, 0.0, 0.0}};
  CHECK_THROWS_AS(Simulation(scene, o), InvalidInput);
  CHECK_THROWS_AS(Simulation(scenes::two_bars(4, Penalty{0.0}), o), InvalidInput);
  CHECK_THROWS_AS(Simulation(scenes::two_bars(4, VolumePenalty{-1.0}), o), InvalidInput);
  scene = scenes::two_bars(4, Multipliers{});
  scene.contact->options.tolerance = 0;
  CHECK_THROWS_AS(Simulation(scene, o), InvalidInput);
  Simulation held(scenes::held_block(), o);
  CHECK_THROWS_AS(held.restore(State{}), InvalidInput);
}

TEST_CASE("mortar faces do not go with the volume penalty") {
  Scene scene = scenes::on_mortar_faces(scenes::two_cubes(VolumePenalty{}), "a.x_max", "b.x_min");
  CHECK_THROWS_WITH_AS(Simulation(scene, options(HilberHughesTaylor{}, 1e-4)),
                       doctest::Contains("Contact: faces = \"mortar\"; must come with multipliers"), InvalidInput);
}

TEST_CASE("an airway of another mesh is refused") {
  const Simulation::Options o = options(HilberHughesTaylor{}, 1e-4);
  const Scene good = scenes::two_bars(4, Multipliers{});
  for (const bool negative : {true, false}) {
    const auto outside = negative ? -1 : static_cast<std::int32_t>(good.mesh.node_count());
    for (int part = 0; part < 3; ++part) {
      Scene scene = good;
      Airway& airway = scene.contact->airway;
      (part == 0 ? airway.first(0, 1) : part == 1 ? airway.second(0, 2) : airway.tets(0, 3)) = outside;
      CHECK_THROWS_WITH_AS(Simulation(scene, o), doctest::Contains("must be in [0, 40)"), InvalidInput);
      CHECK_THROWS_WITH_AS(Detector(airway, scene.mesh.points), doctest::Contains("belongs to another mesh"),
                           InvalidInput);
    }
  }
}

TEST_CASE("couplings, loads and gravity outside their ranges are refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH_AS((Iterated{0.0, 40, 8}.validate()), doctest::Contains("tolerance = 0"), InvalidInput);
  CHECK_THROWS_WITH_AS((Iterated{1e-5, 40, 0}.validate()), doctest::Contains("freeze_after = 0"), InvalidInput);
  CHECK_THROWS_WITH_AS((Iterated{1e-5, 0, 8}.validate()), doctest::Contains("max_sweeps = 0; must be >= 1"),
                       InvalidInput);
  const Simulation::Options o = options(HilberHughesTaylor{}, 1e-4);
  Scene scene = scenes::small_larynx();
  scene.airflow->coupling = Iterated{1e-5, 8, 8};
  CHECK_THROWS_WITH_AS(Simulation(scene, o), doctest::Contains("max_sweeps"), InvalidInput);
  scene = scenes::held_block();
  scene.loads = {{"x_max", {0, nan, 0}, 0.0, 0.0}};
  CHECK_THROWS_WITH_AS(Simulation(scene, o), doctest::Contains("Load: traction.y"), InvalidInput);
  scene.loads = {{"x_max", {0, 1, 0}, -1.0, 0.0}};
  CHECK_THROWS_WITH_AS(Simulation(scene, o), doctest::Contains("frequency = -1 Hz"), InvalidInput);
  scene.loads = {{"x_max", {0, 1, 0}, 1.0, nan}};
  CHECK_THROWS_WITH_AS(Simulation(scene, o), doctest::Contains("phase"), InvalidInput);
  scene.loads.clear();
  scene.gravity = Vector3(0, 0, nan);
  CHECK_THROWS_WITH_AS(Simulation(scene, o), doctest::Contains("gravity"), InvalidInput);
}

TEST_CASE("a state with a part missing or not finite is refused and leaves the simulation as it was") {
  Scene scene = scenes::two_cubes(Multipliers{});  // viscous and with contact: no vector is absent
  Simulation simulation(scene, options(HilberHughesTaylor{}, 1e-4));
  Vector force = Vector::Constant(simulation.step_matrix().rows(), 1e-4);
  simulation.set_external_force(force);
  simulation.advance();
  const State good = simulation.state();
  for (Vector State::*part :
       {&State::displacement, &State::velocity, &State::acceleration, &State::load, &State::contact_force,
        &State::elastic_force, &State::weighted_elastic_force, &State::viscous_force, &State::inertial_force}) {
    State bad = good;
    (bad.*part)[3] = std::numeric_limits<double>::infinity();
    CHECK_THROWS_WITH_AS(simulation.restore(bad), doctest::Contains("not finite"), InvalidInput);
    (bad.*part).conservativeResize(5);
    CHECK_THROWS_WITH_AS(simulation.restore(bad), doctest::Contains("= 5; must be"), InvalidInput);
  }
  State bad = good;
  bad.step = -1;
  CHECK_THROWS_AS(simulation.restore(bad), InvalidInput);
  bad = good;
  bad.depth = -1e-6;
  CHECK_THROWS_AS(simulation.restore(bad), InvalidInput);
  check_equal(simulation.state(), good);
  CHECK(simulation.record().iterations > 0);
  simulation.restore(good);
  CHECK(simulation.record().iterations == 0);
  CHECK(simulation.record().time == simulation.time());
}

TEST_CASE("a state is refused by contact that cannot have its constraints") {
  const auto touching = [](Scene scene) {
    Simulation simulation(std::move(scene), options(HilberHughesTaylor{}, 1e-4));
    while (!simulation.record().contact || simulation.record().contact->rows < 4) simulation.advance();
    return simulation.state();
  };
  const Scene on_means = scenes::on_mortar_faces(scenes::two_cubes(Augmented{}), "a.x_max", "b.x_min");
  Scene on_nodes = on_means;
  on_nodes.contact->faces = AtNodes{};
  State state = touching(on_nodes);  // mid-sides are closed, too
  Simulation mortar(on_means, options(HilberHughesTaylor{}, 1e-4));
  CHECK_THROWS_WITH_AS(mortar.restore(state), doctest::Contains("state's closed constraint"), InvalidInput);
  mortar.restore(touching(on_means));
  Simulation nodes(scenes::two_cubes(Multipliers{}), options(HilberHughesTaylor{}, 1e-4));
  state = touching(scenes::two_cubes(Multipliers{}));
  state.closed.back() = 100'000'000;
  CHECK_THROWS_WITH_AS(nodes.restore(state), doctest::Contains("state's closed constraint = 1"), InvalidInput);
}

TEST_CASE("a step that diverges fails the solve, with step and time") {
  Simulation simulation(scenes::small_larynx(), options(HilberHughesTaylor{}, 1e-4, 1e-8));
  simulation.set_external_force(
      Vector::Constant(simulation.positions().size(), 1e300));  // finite; what it does is not
  CHECK_THROWS_WITH_AS(simulation.advance(), doctest::Contains("Step 1 (t = 0.0001 s): "), SolveFailed);
}

TEST_CASE("a step whose solve does not converge names its time and leaves the last state") {
  Simulation::Options o = options(HilberHughesTaylor{}, 1e-2, 1e-8);
  o.solver.method =
      LinearSolver::ConjugateGradients{1};  // too few for any motion; at rest without load none is needed
  Scene scene = scenes::held_block();
  Simulation simulation(scene, o);
  Vector force = Vector::Zero(simulation.step_matrix().rows());
  for (const auto node : scene.mesh.node_set("x_max")) force[3 * node + 1] = 1e-3;
  simulation.set_external_force(force);
  CHECK_THROWS_WITH_AS(simulation.advance(), doctest::Contains("t = 0.01 s"), SolveFailed);
  CHECK(simulation.state().step == 0);
  CHECK(simulation.state().displacement.isZero(0));
}

TEST_CASE("a velocity that strains nothing is told from the state's energy") {
  Scene scene = scenes::held_block(0.3, 0.5);
  scene.supports = Supports(scene.mesh.node_count());
  scene.gravity = Vector3(0, 0, -9.81);
  for (const Simulation::Options& how : {options(HilberHughesTaylor{}, 1e-4), options(Newmark{}, 1e-4)}) {
    Simulation simulation(scene, how);
    simulation.advance();
    State pushed = simulation.state();
    for (std::ptrdiff_t i = 0; i < pushed.velocity.size(); i += 3) pushed.velocity[i] += 0.1;
    CHECK_THROWS_WITH_AS(simulation.restore(pushed), doctest::Contains("kinetic energy"), InvalidInput);
    const State renewed = simulation.renewed(pushed);
    simulation.restore(renewed);
    const double x = simulation.state().displacement[0];
    simulation.advance();
    CHECK(simulation.state().displacement[0] - x == approx(0.1 * 1e-4).epsilon(1e-6));
    CHECK(std::abs(simulation.state().ledger.error()) <= 1e-9 * simulation.state().ledger.kinetic);
  }
}

TEST_CASE("a state whose products contradict its motion is refused, and goes on with renewed ones") {
  const auto kicked = [](State state) {
    state.velocity *= 1.5;
    return state;
  };
  const auto check = [&](Scene scene, const Simulation::Options& how, const char* product) {
    Simulation simulation(scene, how), other(scene, how);
    for (int k = 0; k < 3; ++k) simulation.advance();
    const State state = simulation.state();
    REQUIRE(state.velocity.norm() > 0);
    other.restore(state);  // untouched: kept to the bit
    check_equal(other.state(), state);
    State wrong = kicked(state);
    if (product) {
      CHECK_THROWS_WITH_AS(other.restore(wrong), doctest::Contains(product), InvalidInput);
      check_equal(other.state(), state);
    }
    wrong = other.renewed(wrong);
    CHECK(wrong.velocity == kicked(state).velocity);
    CHECK(wrong.ledger.error() == approx(state.ledger.error()).epsilon(1e-9));
    other.restore(wrong);
    other.advance();
    const Vector moved_by = other.state().displacement - state.displacement;
    CHECK(moved_by.norm() > 0);
    other.restore(other.renewed(wrong));  // renewing twice is renewing once
    other.advance();
    CHECK((other.state().displacement - state.displacement - moved_by).norm() <= 1e-9 * moved_by.norm());
    State accelerated = state;
    accelerated.acceleration *= 2;
    CHECK_THROWS_WITH_AS(other.restore(accelerated), doctest::Contains("inertial_force"), InvalidInput);
    State moved = state;
    moved.displacement *= 1.25;
    CHECK_THROWS_WITH_AS(other.restore(moved), doctest::Contains("elastic_force from K u = 0.2"), InvalidInput);
  };
  Scene scene = scenes::held_block(0.3, 0.5);
  scene.gravity = Vector3(0, 0, -9.81);
  SUBCASE("of all nodes") {
    check(scene, options(HilberHughesTaylor{}, 1e-4), "stiffness_velocity from K v = 0.333");
    check(scene, options(Newmark{}, 1e-4), "viscous_force from C V = 0.333");
  }
  SUBCASE("not viscous") {
    Scene elastic = scenes::held_block();
    elastic.gravity = scene.gravity;
    check(elastic, options(HilberHughesTaylor{}, 1e-4), "stiffness_velocity from K v = 0.333");
  }
  SUBCASE("explicit") {
    Simulation::Options how = options(CentralDifferences{}, 1e-5);
    how.mass = Simulation::Mass::lumped;
    check(scene, how, nullptr);  // nothing of theirs is a product with v alone
  }
}

TEST_CASE("a state with a past that contradicts the step matrix is refused") {
  Scene scene = scenes::held_block();
  scene.gravity = Vector3(0, 0, -9.81);
  Simulation simulation(scene, options(HilberHughesTaylor{}, 1e-4));
  for (int k = 0; k < 3; ++k) simulation.advance();
  State state = simulation.state();
  state.past.images.back() *= 1.01;
  CHECK_THROWS_WITH_AS(simulation.restore(state), doctest::Contains("past.images from A a"), InvalidInput);
}

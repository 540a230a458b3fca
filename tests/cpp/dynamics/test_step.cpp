// How a step is solved: from where the last ones have been, by superposition, with products carried along.
#include <doctest/doctest.h>

#include "plica/core/threads.hpp"
#include "plica/dynamics/past.hpp"
#include "plica/dynamics/pressure_response.hpp"
#include "plica/dynamics/reduced_step.hpp"
#include "plica/dynamics/scene_flow.hpp"
#include "plica/dynamics/step.hpp"
#include "reduced_scenes.hpp"

using namespace plica;
using scenes::options;
using scenes::relative;

namespace {

/// A larynx without contact in which one fold begins below the sections and the other ends above them.
Scene staggered_folds() {
  Scene scene = scenes::small_larynx();
  scene.contact.reset();
  const Faces whole = scene.mesh.surface("airway");
  const Indices nodes = whole.reshaped<Eigen::RowMajor>();
  const Vector z = scene.mesh.points(nodes, 2);
  const double low = z.minCoeff(), quarter = 0.25 * (z.maxCoeff() - low);
  std::vector<std::ptrdiff_t> kept;
  for (std::ptrdiff_t f = 0; f < whole.rows(); ++f) {
    const Vector3 middle = scene.mesh.points(whole.row(f), Eigen::all).colwise().mean();
    if (middle[0] > 0 ? middle[2] > low + quarter : middle[2] < low + 3 * quarter) kept.push_back(f);
  }
  scene.mesh.surfaces.at("airway") = whole(kept, Eigen::all);
  scene.airflow->flow.area = CutSections{8};
  return scene;
}

}  // namespace

TEST_CASE("the start is the combination of past accelerations that leaves the least residual") {
  const int n = 3 * 5000;  // several chunks
  const Eigen::MatrixXd X = Eigen::MatrixXd::Random(n, 4);
  Past past;
  CHECK(past.nearest(Vector::Ones(6)).x == Vector::Zero(6));
  const auto image = [](const Vector& x) { return Vector(x.array() * Vector::LinSpaced(x.size(), 1, 9).array()); };
  for (int k = 0; k < 4; ++k) past.add(X.col(k), image(X.col(k)));
  const Vector inside = X * Vector::LinSpaced(4, -1, 2);
  CHECK(relative(past.nearest(image(inside)).x, inside) < 1e-12);
  const Vector b = image(inside) + Vector::Random(n);
  const Guess guess = past.nearest(b);
  CHECK(relative(guess.product, image(guess.x)) < 1e-12);
  for (int k = 0; k < 4; ++k)  // what is left is orthogonal to every image
    CHECK(std::abs((b - guess.product).dot(image(X.col(k)))) < 1e-10 * b.norm() * image(X.col(k)).norm());
  set_threads(3);
  CHECK(past.nearest(b).x == guess.x);
  set_threads(1);
}

TEST_CASE("past accelerations that repeat each other start as one does, and no more than depth are kept") {
  const Vector x = Vector::Random(30), b = Vector::Random(30);
  Past one, many;
  one.add(x, 2 * x);
  for (std::size_t k = 0; k < Past::depth + 3; ++k) many.add(x, 2 * x);
  CHECK(many.images.size() == Past::depth);
  CHECK(relative(many.nearest(b).x, one.nearest(b).x) < 1e-9);
  Past still;
  still.add(Vector::Zero(30), Vector::Zero(30));
  CHECK(still.nearest(b).x == Vector::Zero(30));
}

TEST_CASE("the response to section pressures is the solution under their load") {
  const Scene scene = scenes::small_larynx();
  Simulation simulation(scene, options(HilberHughesTaylor{}, 1e-4, 1e-12));
  const Airflow& airflow = *simulation.airflow();
  const std::ptrdiff_t unknowns = simulation.step_matrix().rows();
  const auto solver = LinearSolver::make(simulation.step_matrix(), {1e-12});
  const Assembler assembler(scene.mesh);
  const Motion motion(scene, nullptr, assembler, options(HilberHughesTaylor{}, 1e-4, 1e-12));
  const PressureResponse response(airflow, motion, airflow.nodes());
  const Vector pressure = Vector::Random(airflow.sections().count());
  Vector load = Vector::Zero(unknowns), offset = load;  // the load at zero is what lies below the first section
  airflow.add_load(simulation.positions(), {airflow.options().subglottal_pressure, pressure}, load);
  airflow.add_load(simulation.positions(), {airflow.options().subglottal_pressure, Vector::Zero(pressure.size())},
                   offset);
  load -= offset;
  simulation.scene().supports.project(load);
  Guess guess;
  REQUIRE(solver->solve(load, guess).converged);
  REQUIRE(guess.x.norm() > 0);
  Vector a = Vector::Zero(unknowns);
  response.add(pressure, a);
  CHECK(relative(a, guess.x) < 1e-6);  // single precision
  Points x = Points::Zero(unknowns / 3, 3);
  response.displace(pressure, 2.0, x);
  const Points expected = 2.0 * as_points(guess.x)(airflow.nodes(), Eigen::all);
  CHECK((x(airflow.nodes(), Eigen::all) - expected).norm() < 1e-10 * expected.norm());
}

TEST_CASE("where a step is moved to depends on its last move alone, whatever pressed at its ends before") {
  const Scene scene = staggered_folds();
  const Simulation::Options how = options(HilberHughesTaylor{}, 1e-4, 1e-12);
  Simulation simulation(scene, how);
  simulation.advance();
  const Assembler assembler(scene.mesh);
  const Motion motion(scene, nullptr, assembler, how);
  SceneFlow flow(scene, motion);
  flow.find_response(Iterated{}, motion, flow.airflow().nodes(), false);
  REQUIRE(flow.response() != nullptr);
  const std::ptrdiff_t sections = flow.airflow().sections().count();
  const Vector pressure = Vector::LinSpaced(sections, 500, 200);
  constexpr auto at = CoupledStep::Instant::weighted;
  const auto moved = [&](const std::vector<AirwayPressure>& by) {
    StepTimes times;
    Step step(motion, simulation.state(), Vector::Zero(motion.stiffness().rows()), flow.airflow().nodes(), &flow,
              nullptr, times);
    for (const AirwayPressure& each : by) step.move(each, at);
    const Points displacement = step.weighted_positions() - scene.mesh.points;
    step.complete();
    return std::pair{Vector(as_vector(displacement)), step.end().acceleration};
  };
  const AirwayPressure low{500, pressure, 200}, high{800, 1.5 * pressure, 0};
  const auto once = moved({low}), twice = moved({high, low}), elsewhere = moved({high}),
             sealed = moved({{500, pressure, 0}});
  CHECK(relative(twice.first, once.first) < 1e-9);
  CHECK(relative(twice.second, once.second) < 1e-9);
  CHECK(relative(elsewhere.second, once.second) > 1e-2);
  CHECK(relative(sealed.second, once.second) > 1e-3);
}

TEST_CASE("a reduced step too depends on its last move alone, whatever pressed at its ends before") {
  Scene scene = staggered_folds();
  const std::ptrdiff_t size = scene.mesh.points.size();
  scene = scenes::reduced(std::move(scene), Eigen::MatrixXd::Random(size, 6));
  const Simulation::Options how = options(HilberHughesTaylor{}, 1e-4, 1e-12);
  Simulation simulation(scene, how);
  simulation.advance();
  const Assembler assembler(scene.mesh);
  const Motion full(scene, nullptr, assembler, how);
  const ModalMotion& motion = simulation.reduced()->motion();
  const Mediolateral& positions = simulation.reduced()->positions();
  ReducedFlow flow(*simulation.airflow(), full, motion, positions, true);
  const Vector pressure = Vector::LinSpaced(simulation.airflow()->sections().count(), 500, 200);
  const auto moved = [&](const AirwayPressure& begun, const AirwayPressure& by) {
    StepTimes times;
    ReducedStep step(motion, positions, &flow, nullptr, full.origin());
    step.begin(simulation.state(), Vector::Zero(motion.size()), begun, times);
    step.move(by, CoupledStep::Instant::weighted);
    State now;
    step.end(now);
    return std::tuple{step.areas(CoupledStep::Instant::weighted), now.acceleration, now.flow_load};
  };
  const AirwayPressure begun{500, {}, 200};
  const AirwayPressure at_ends{500, pressure, 200};
  const auto known = moved(begun, at_ends), learned = moved({800, {}, 0}, at_ends);
  CHECK(relative(std::get<0>(learned), std::get<0>(known)) < 1e-9);  // what moves the sections is single
  CHECK(relative(std::get<1>(learned), std::get<1>(known)) < 1e-12);
  CHECK(std::get<2>(learned) == std::get<2>(known));
  ReducedFlow held(*simulation.airflow(), full, motion, positions, false);
  CHECK(held.moving(at_ends, begun) == pressure);
  CHECK_THROWS_AS(held.moving(at_ends, {800, {}, 200}), InvalidInput);
  Vector load = Vector::Zero(size);
  simulation.airflow()->add_load(scene.mesh.points, at_ends, load);
  CHECK(relative(std::get<2>(known), motion.forces(load)) < 1e-9);
  CHECK(relative(std::get<1>(moved(begun, {800, pressure, 200})), std::get<1>(known)) > 1e-3);
  CHECK(relative(std::get<1>(moved(begun, {500, pressure, 0})), std::get<1>(known)) > 1e-3);
}

TEST_CASE("products that are carried along stay those of the state") {
  Scene scene = scenes::small_larynx();
  Simulation simulation(scene, options(HilberHughesTaylor{}, 1e-4, 1e-8));
  for (int k = 0; k < 63; ++k) simulation.advance();
  const State& s = simulation.state();
  CHECK(relative(s.elastic_force, simulation.stiffness() * s.displacement) < 1e-11);
  CHECK(relative(s.stiffness_velocity, simulation.stiffness() * s.velocity) < 1e-11);
  CHECK(relative(s.stiffness_acceleration, simulation.stiffness() * s.acceleration) < 1e-13);
  CHECK(relative(s.viscosity_velocity, *simulation.viscosity() * s.velocity) < 1e-11);
  CHECK(relative(s.inertial_force, simulation.mass() * s.acceleration) < 1e-13);
  CHECK(s.past.accelerations.front() == s.acceleration);
  Vector image = simulation.step_matrix() * s.acceleration;
  CHECK(relative(s.past.images.front(), image) < 1e-13);
  simulation.advance();  // the 64th
  CHECK(simulation.state().elastic_force == simulation.stiffness() * simulation.state().displacement);
}

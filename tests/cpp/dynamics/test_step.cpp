// How a step is solved: from where the last ones have been, by superposition, with products carried along.
#include <doctest/doctest.h>

#include "plica/core/threads.hpp"
#include "plica/dynamics/past.hpp"
#include "plica/dynamics/pressure_response.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;
using scenes::relative;

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
  airflow.add_load(simulation.positions(), airflow.options().subglottal_pressure, pressure, load);
  airflow.add_load(simulation.positions(), airflow.options().subglottal_pressure, Vector::Zero(pressure.size()),
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

#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <complex>
#include <random>

#include "../approx.hpp"
#include "plica/core/error.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

Points random_field(std::ptrdiff_t nodes, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-size, size);
  Points field(nodes, 3);
  for (std::ptrdiff_t i = 0; i < field.size(); ++i) field.data()[i] = value(random);
  return field;
}

double energy(const Simulation& simulation) {
  return simulation.state().ledger.kinetic + simulation.state().ledger.elastic;
}

const std::vector<TimeScheme> dissipative = {HilberHughesTaylor{-0.3}, HilberHughesTaylor{-0.1},
                                             HilberHughesTaylor{-1.0 / 3}};

}  // namespace

TEST_CASE("a mode of viscosity alone travels its momentum over its damping, whatever the step") {
  for (const TimeScheme& scheme : dissipative)
    for (const double z : {0.5, 5.0, 50.0, 5000.0}) {
      Scene scene = scenes::held_block(0.3, 100.0);
      scene.tissue.materials[0].elasticity = Isotropic{1e-9, 0.3};  // none to speak of
      const std::vector<int> unknowns = scenes::free_unknowns(scene.supports);
      const Simulation probe(scene, options(scheme, 1e-4));
      const Eigen::MatrixXd M = scenes::free_part(probe.mass().to_sparse(), unknowns);
      const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(
          scenes::free_part(probe.viscosity()->to_sparse(), unknowns), M);
      const int mode = 2;
      const double rate = modes.eigenvalues()[mode], h = z / rate;
      const Vector phi = modes.eigenvectors().col(mode), M_phi = M * phi;
      scene.velocity = Points::Zero(scene.mesh.node_count(), 3);
      for (std::size_t i = 0; i < unknowns.size(); ++i)
        scene.velocity->data()[unknowns[i]] = phi[static_cast<std::ptrdiff_t>(i)];
      Simulation simulation(scene, options(scheme, h));
      for (int k = 0; k < 60; ++k) simulation.advance();
      const SchemeCoefficients s = scheme_coefficients(scheme);
      const double waits = (1 + s.alpha) * s.gamma * z;
      const double travel = rate * M_phi.dot(Vector(simulation.state().displacement(unknowns)));
      // The closed form of docs/theory/time.md; at most 0.01 of a step's motion off the exact 1.
      CHECK(travel == approx(1 + s.alpha * s.alpha / 4 * z * z / std::pow(1 + waits, 2)).epsilon(1e-6));
      CHECK(std::abs(travel - 1) < 0.013 * z);
    }
}

TEST_CASE("no stiff start makes energy, and its ledger closes") {
  unsigned seed = 1;
  for (const TimeScheme& scheme : {TimeScheme(HilberHughesTaylor{-0.3}), TimeScheme(HilberHughesTaylor{-0.1})})
    for (const double viscosity : {0.0, 3.0, 300.0, 3e4})
      for (const double h : {1e-4, 1e-2}) {
        Scene scene = scenes::held_block(0.3, viscosity);
        scene.velocity = random_field(scene.mesh.node_count(), 1.0, seed);
        scene.displacement = random_field(scene.mesh.node_count(), 1e-3, seed + 1);
        seed += 2;
        Simulation simulation(scene, options(scheme, h));
        const double initial = simulation.state().ledger.initial;
        for (int k = 0; k < 30; ++k) {
          simulation.advance();
          CHECK(energy(simulation) <= initial);
          CHECK(std::abs(simulation.state().ledger.error()) < 1e-10 * initial);
          CHECK(simulation.state().ledger.numerical_loss > -0.2 * initial);
        }
      }
}

TEST_CASE("a load on stiff tissue at rest does not throw it beyond what the load has done") {
  for (const TimeScheme& scheme : dissipative)
    for (const double viscosity : {0.0, 300.0}) {
      Scene scene = scenes::held_block(0.3, viscosity);
      scene.loads = {{"x_max", {50, 20, -10}, 0.0, 0.0}};
      Simulation simulation(scene, options(scheme, 1e-1));
      for (int k = 0; k < 30; ++k) {
        simulation.advance();
        const Ledger& ledger = simulation.state().ledger;
        CHECK(ledger.kinetic + ledger.elastic <= ledger.load_work);
        CHECK(std::abs(ledger.error()) < 1e-10 * ledger.load_work);
      }
    }
}

TEST_CASE("stiff viscous motion follows the exact one of the semi-discrete equations") {
  Scene scene = scenes::held_block(0.3, 3000.0);  // the fastest mode decays some 30 times in a step
  scene.velocity = random_field(scene.mesh.node_count(), 1.0, 7);
  const double h = 5e-5, end = 1e-3;
  const std::vector<int> unknowns = scenes::free_unknowns(scene.supports);
  const auto n = static_cast<std::ptrdiff_t>(unknowns.size());
  Simulation simulation(scene, options(HilberHughesTaylor{-0.3}, h));
  const Eigen::MatrixXd M = scenes::free_part(simulation.mass().to_sparse(), unknowns),
                        C = scenes::free_part(simulation.viscosity()->to_sparse(), unknowns),
                        K = scenes::free_part(simulation.stiffness().to_sparse(), unknowns);
  Eigen::MatrixXd motion = Eigen::MatrixXd::Zero(2 * n, 2 * n);  // of (u, v)
  motion.topRightCorner(n, n).setIdentity();
  motion.bottomLeftCorner(n, n) = -M.llt().solve(K);
  motion.bottomRightCorner(n, n) = -M.llt().solve(C);
  const Eigen::EigenSolver<Eigen::MatrixXd> modes(motion);
  CHECK(modes.eigenvalues().cwiseAbs().maxCoeff() * h > 20);
  Eigen::VectorXcd start = Eigen::VectorXcd::Zero(2 * n);
  start.tail(n) = Vector(simulation.state().velocity(unknowns)).cast<std::complex<double>>();
  const Eigen::VectorXcd shares = modes.eigenvectors().partialPivLu().solve(start);
  const Eigen::VectorXcd grown = (modes.eigenvalues() * end).array().exp() * shares.array();
  const Vector exact = (modes.eigenvectors() * grown).real().head(n);
  while (simulation.time() < end - 0.5 * h) simulation.advance();
  const Vector u = simulation.state().displacement(unknowns);
  CHECK((u - exact).norm() < 0.05 * exact.norm());
}

TEST_CASE(
    "work of a load that varies is that of its own instants, so the scheme takes and makes next to nothing") {
  Scene scene = scenes::held_block(0.3, 1.5);
  scene.loads = {{"x_max", {30, 20, -10}, 40.0, -1.6}};  // well below resonance: most of its work comes back
  double loss[2];
  for (int k = 0; k < 2; ++k) {
    const int steps = 200 << k;
    Simulation simulation(scene, options(HilberHughesTaylor{-0.3}, 0.1 / steps));
    double work = 0;
    for (int i = 0; i < steps; ++i) {
      simulation.advance();
      work = std::max(work, simulation.state().ledger.load_work);
    }
    loss[k] = std::abs(simulation.state().ledger.numerical_loss) / work;
    CHECK(std::abs(simulation.state().ledger.error()) < 1e-10 * work);
  }
  CHECK(loss[0] < 0.05);
  CHECK(loss[0] / loss[1] > 3);  // second order
}

TEST_CASE("a simulation returned to its first state steps as it did") {
  Scene scene = scenes::two_cubes(Multipliers{}, 300.0);
  Simulation simulation(scene, options(HilberHughesTaylor{}, 1e-4)),
      other(scene, options(HilberHughesTaylor{}, 1e-4));
  const State start = simulation.state();
  for (int k = 0; k < 5; ++k) simulation.advance();
  const State first = simulation.state();
  simulation.restore(start);
  other.restore(start);
  for (int k = 0; k < 5; ++k) {
    simulation.advance();
    other.advance();
  }
  CHECK(simulation.state().displacement == first.displacement);
  CHECK(simulation.state().ledger.numerical_loss == first.ledger.numerical_loss);
  CHECK(other.state().displacement == first.displacement);
}

TEST_CASE("a start that cannot be solved for says whether rounding or the iterations are to blame") {
  Scene scene = scenes::held_block(0.3, 1.0);
  scene.gravity = Vector3(0, 0, -9.81);
  const auto begin = [&](double tolerance, const LinearSolver::Method& method) {
    Simulation(scene, {HilberHughesTaylor{}, 1e-4, {tolerance, method}, Simulation::Mass::consistent});
  };
  CHECK_NOTHROW(begin(1e-12, LinearSolver::Cholesky{}));
  CHECK_THROWS_WITH_AS(begin(1e-18, LinearSolver::Cholesky{}),
                       doctest::Contains("Rounding allows no less: loosen solver.tolerance"), SolveFailed);
  CHECK_THROWS_WITH_AS(begin(1e-12, LinearSolver::ConjugateGradients{1}),
                       doctest::Contains("Raise max_iterations of solver.method.conjugate_gradients"),
                       SolveFailed);
}

#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <complex>

#include "../approx.hpp"
#include "plica/core/error.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

/// One step of a scheme for a single mass of frequency Omega / h, on (u, h v, h^2 a).
Matrix3 amplification(const SchemeCoefficients& s, double omega) {
  const double o2 = omega * omega, w = 1 + s.alpha, lead = 1 + w * s.beta * o2;
  Matrix3 A;
  A.row(2) = -o2 / lead * Vector3(w - s.alpha, w, w * (0.5 - s.beta)).transpose();
  A.row(0) = Vector3(1, 1, 0.5 - s.beta).transpose() + s.beta * A.row(2);
  A.row(1) = Vector3(0, 1, 1 - s.gamma).transpose() + s.gamma * A.row(2);
  return A;
}

const TimeScheme trapezoidal = Newmark{};

}  // namespace

TEST_CASE("an eigenmode of a block steps as the closed form says") {
  for (const TimeScheme& scheme :
       {TimeScheme(HilberHughesTaylor{-0.3}), TimeScheme(HilberHughesTaylor{-0.1}),
        TimeScheme(HilberHughesTaylor{-1.0 / 3}), TimeScheme(Newmark{1.0, 1.5}), trapezoidal})
    for (const double omega : {0.3, 1.0, 5.0}) {
      Scene scene = scenes::held_block();
      const std::vector<int> unknowns = scenes::free_unknowns(scene.supports);
      const Simulation probe(scene, options(scheme, 1e-4));
      const Eigen::MatrixXd M = scenes::free_part(probe.mass().to_sparse(), unknowns),
                            K = scenes::free_part(probe.stiffness().to_sparse(), unknowns);
      const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(K, M);
      const int mode = 2;
      const double h = omega / std::sqrt(modes.eigenvalues()[mode]);
      const Vector phi = modes.eigenvectors().col(mode), M_phi = M * phi;

      scene.displacement = Points::Zero(scene.mesh.node_count(), 3);
      for (std::size_t i = 0; i < unknowns.size(); ++i)
        scene.displacement->data()[unknowns[i]] = phi[static_cast<std::ptrdiff_t>(i)];
      Simulation simulation(scene, options(scheme, h));
      const SchemeCoefficients s = scheme_coefficients(scheme);
      const Matrix3 A = amplification(s, omega);
      Vector3 exact(1, 0, -omega * omega), force = Vector3::Zero();
      if (const double excess = s.beta - s.gamma / 2; excess > 0) {  // docs/theory/time.md, "The first step"
        const double k = (1 + s.alpha) * s.beta * omega * omega, p = -omega * omega / (1 + k), d = p - p / (1 + k);
        exact[2] = p + d;
        // The shift counts as a displacement, but not as what the elastic force of the step before was of.
        const double shift = ((1 + s.alpha) * s.gamma / 2 + 2 * excess) * d;
        const double lead = 1 + k, behind = (1 + s.alpha) * s.beta * d;
        const double acceleration = -omega * omega / lead * ((1 + s.alpha) * shift - s.alpha * behind);
        force = Vector3(shift + s.beta * acceleration, s.gamma * acceleration, acceleration);
      }
      for (int k = 0; k < 40; ++k) {
        simulation.advance();
        exact = A * exact + force;
        force.setZero();
        const Vector u = simulation.state().displacement(unknowns), v = simulation.state().velocity(unknowns);
        CHECK(M_phi.dot(u) == approx(exact[0]).epsilon(1e-9).scale(1));
        CHECK(h * M_phi.dot(v) == approx(exact[1]).epsilon(1e-9).scale(omega));
      }
    }
}

TEST_CASE("displacement and velocity converge at each scheme's order to the exact forced motion") {
  struct Case {
    TimeScheme scheme;
    double order;
  };
  const double pi = std::acos(-1.0), frequency = 60, w = 2 * pi * frequency, end = 0.012;
  for (const Case& c : {Case{HilberHughesTaylor{-0.3}, 2}, Case{HilberHughesTaylor{-0.1}, 2},
                        Case{HilberHughesTaylor{-1.0 / 3}, 2}, Case{trapezoidal, 2}, Case{Newmark{1.0, 1.5}, 1}}) {
    Scene scene = scenes::held_block(0.3, 1.5);
    scene.loads = {{"x_max", {30, 20, -10}, frequency, 0.0}};
    const std::vector<int> unknowns = scenes::free_unknowns(scene.supports);
    const Simulation probe(scene, options(c.scheme, 1e-4));
    const Vector F = Vector(probe.state().load(unknowns));  // at t = 0, where the cosine is 1
    // Steady state u = Re z e^(i w t), (K + i w C - w^2 M) z = F: exact, viscosity and every mode included.
    using Complex = std::complex<double>;
    const Eigen::MatrixXcd D = scenes::free_part(probe.stiffness().to_sparse(), unknowns).cast<Complex>() +
                               Complex(0, w) * scenes::free_part(probe.viscosity()->to_sparse(), unknowns) -
                               w * w * scenes::free_part(probe.mass().to_sparse(), unknowns).cast<Complex>();
    const Eigen::VectorXcd z = D.partialPivLu().solve(F.cast<Complex>());
    const auto at = [&](double t) { return Vector((z * std::exp(Complex(0, w * t))).real()); };
    const auto rate_at = [&](double t) {
      return Vector((Complex(0, w) * z * std::exp(Complex(0, w * t))).real());
    };
    scene.displacement = Points::Zero(scene.mesh.node_count(), 3);
    scene.velocity = scene.displacement;
    const Vector u0 = at(0), v0 = rate_at(0);
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      scene.displacement->data()[unknowns[i]] = u0[static_cast<std::ptrdiff_t>(i)];
      scene.velocity->data()[unknowns[i]] = v0[static_cast<std::ptrdiff_t>(i)];
    }
    double error_u[2], error_v[2];
    for (int k = 0; k < 2; ++k) {
      const int steps = 60 << k;
      Simulation simulation(scene, options(c.scheme, end / steps));
      for (int i = 0; i < steps; ++i) simulation.advance();
      error_u[k] = (simulation.state().displacement(unknowns) - at(end)).norm() / z.norm();
      error_v[k] = (simulation.state().velocity(unknowns) - rate_at(end)).norm() / (w * z.norm());
    }
    CAPTURE(c.order);
    CHECK(error_u[0] < 0.3);
    // Between h and h/2 the next term of the error still shows: a tenth of an order at these steps.
    CHECK(std::log2(error_u[0] / error_u[1]) == approx(c.order).epsilon(0.1));
    CHECK(std::log2(error_v[0] / error_v[1]) == approx(c.order).epsilon(0.1));
  }
}

TEST_CASE("scheme parameters out of range are named") {
  CHECK_THROWS_AS(scheme_coefficients(Newmark{0.0, 0.5}), InvalidInput);
  CHECK_THROWS_AS(scheme_coefficients(Newmark{0.25, 0.4}), InvalidInput);
  CHECK_THROWS_AS(scheme_coefficients(Newmark{0.25, 0.6}), InvalidInput);
  CHECK_THROWS_AS(scheme_coefficients(HilberHughesTaylor{-0.4}), InvalidInput);
  CHECK_THROWS_AS(scheme_coefficients(HilberHughesTaylor{0.1}), InvalidInput);
  CHECK_NOTHROW(scheme_coefficients(HilberHughesTaylor{-1.0 / 3}));
  Simulation::Options zero;
  zero.step = 0;
  CHECK_THROWS_AS(Simulation(scenes::held_block(), zero), InvalidInput);
}

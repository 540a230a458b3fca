// A tube as a linear system, against its steps in time and closed forms.
#include <doctest/doctest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <complex>

#include "../approx.hpp"
#include "plica/airflow/line_system.hpp"
#include "plica/core/constants.hpp"

using namespace plica;

namespace {

constexpr Gas warm_air{1.2, 350.0, 1.8e-5};

Tube any_tube(int end, bool yields) {
  Tube tube{{0.02, 0.05, 0.1}, {1e-4, 4e-4, 2e-4}, Radiation{}, {}, 1000.0};
  if (end == 1) tube.end = PressureSupply{1.0, 0.0};
  if (end == 2) tube.end = PressureSupply{0.3, 1e-5};
  if (end == 3) tube.end = FlowSupply{2e-5};
  if (yields) tube.wall = YieldingWall{};
  return tube;
}

}  // namespace

TEST_CASE("the midpoint rule on the system is a substep of the line") {
  for (const int end : {0, 2, 3})
    for (const bool yields : {false, true}) {
      CAPTURE(end);
      const TransmissionLine line(any_tube(end, yields), warm_air, "tube", 0.01);
      const LineSystem system = line_system(line);
      REQUIRE(system.storage.size() == line.size());
      const double h = 5e-6, flow = 2e-4, flow_then = 3e-4;
      Vector x = line.steady(1e-4, 0.0);
      for (std::ptrdiff_t k = 0; k < x.size(); ++k) x[k] *= 1 + 0.3 * std::sin(1.7 * static_cast<double>(k));
      const double source = end == 0 ? 0.0 : end == 2 ? 500.0 : 1e-4, source_then = 1.2 * source;
      LineStep step(line, h, h);
      step.begin(x, flow, source, source_then);
      const Vector expected = step.end(flow_then);
      const Eigen::MatrixXd E = system.storage.asDiagonal(), &A = system.rates;
      Vector right = (E + 0.5 * h * A) * x;
      right[0] += h * 0.5 * (flow + flow_then);
      right += h * 0.5 * (source + source_then) * system.source;
      const Vector found = (E - 0.5 * h * A).partialPivLu().solve(right);
      const auto size = [&](const Vector& v) { return std::sqrt(v.dot(system.storage.cwiseProduct(v))); };
      CHECK(size(expected - x) > 1e-3 * size(x));
      CHECK(size(found - expected) < 1e-9 * size(x));
      CHECK(0.5 * x.dot(system.storage.cwiseProduct(x)) == approx(line.energy(x)).epsilon(1e-12));
    }
}

TEST_CASE("a pressure that is held at the far end stands in all of the tube") {
  for (const int end : {1, 2})
    for (const bool yields : {false, true}) {
      const TransmissionLine line(any_tube(end, yields), warm_air, "tube", 0.01);
      const LineSystem system = line_system(line);
      const Vector x = -system.rates.partialPivLu().solve(700.0 * system.source);
      CHECK(x[0] == approx(700.0).epsilon(1e-9));
      CHECK((system.rates * x + 700.0 * system.source).norm() < 1e-9 * (700.0 * system.source).norm());
    }
}

TEST_CASE("no tube gains energy by itself") {
  for (const int end : {0, 1, 2, 3})
    for (const bool yields : {false, true}) {
      const LineSystem system = line_system(TransmissionLine(any_tube(end, yields), warm_air, "tube", 0.01));
      const Eigen::MatrixXd symmetric = 0.5 * (system.rates + system.rates.transpose());
      CHECK(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric).eigenvalues().maxCoeff() <=
            1e-12 * system.rates.cwiseAbs().maxCoeff());
    }
}

TEST_CASE("the system has the impedance and the outflow of the line at any complex frequency") {
  for (const int end : {0, 1, 2, 3})
    for (const bool yields : {false, true}) {
      CAPTURE(end);
      const TransmissionLine line(any_tube(end, yields), warm_air, "tube", 0.01);
      const auto [storage, rates, outflow, source] = line_system(line);
      for (const std::complex<double> s : {std::complex<double>(-30.0, 900.0), {200.0, 7000.0}}) {
        Eigen::MatrixXcd matrix = -rates.cast<std::complex<double>>();
        matrix.diagonal() += s * storage.cast<std::complex<double>>();
        const Eigen::VectorXcd into = Eigen::VectorXcd::Unit(storage.size(), 0);
        const Eigen::VectorXcd x = matrix.partialPivLu().solve(into);
        const auto [impedance, transfer] = line.response(s);
        CHECK(std::abs(x[0] - impedance) < 1e-9 * std::abs(impedance));
        const std::complex<double> out = outflow.cast<std::complex<double>>().dot(x);
        CHECK(std::abs(out - transfer) <= 1e-9 * std::abs(transfer));
        CHECK((transfer == 0.0) == (end == 3));
      }
    }
}

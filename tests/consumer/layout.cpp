// Eigen objects that cross the border between an embedder and the library, both ways: memory of either is resized
// and freed by the other, and what the embedder computes with vector instructions of its own is right.
#include <Eigen/Dense>
#include <iostream>
#include <plica/dynamics/simulation.hpp>
#include <plica/tissue/material.hpp>

#include "bar.hpp"

namespace {

bool agrees(const char* what, double off, double tolerance) {
  const bool good = off <= tolerance;
  std::cout << what << ": off by " << off << (good ? "" : "  <- WRONG") << '\n';
  return good;
}

}  // namespace

int main() {
  // Dense products, which rely on the alignment of what they allocate: against sums written out.
  const Eigen::MatrixXd A = Eigen::MatrixXd::Random(67, 59), B = Eigen::MatrixXd::Random(59, 71);
  Eigen::MatrixXd C = A * B;
  double off = 0.0;
  for (Eigen::Index i = 0; i < C.rows(); ++i)
    for (Eigen::Index j = 0; j < C.cols(); ++j) {
      double sum = 0.0;
      for (Eigen::Index k = 0; k < A.cols(); ++k) sum += A(i, k) * B(k, j);
      off = std::max(off, std::abs(C(i, j) - sum));
    }
  bool good = agrees("dense product", off, 1e-13);  // 59 terms below 1

  // Fixed sizes in the library's structures, which must lie where the library puts them.
  const plica::Material tissue{plica::Isotropic{20e3, 0.3}, 1020.0, 1.0};  // Pa, -, kg/m^3, Pa s
  const plica::Matrix6 S = plica::elasticity_matrix(tissue);
  const double shear = 20e3 / (2 * 1.3);
  good = agrees("shear modulus", (S.bottomRightCorner<3, 3>() - shear * plica::Matrix3::Identity()).norm(),
                1e-10 * shear) &&
         good;

  // A mesh made here is freed there, a state made there is freed here.
  for (int across = 1; across <= 3; ++across) {
    plica::TetMesh mesh = plica::to_quadratic(make_bar(4, across));
    plica::Supports supports(mesh.node_count());
    for (const std::int32_t node : mesh.node_set("clamp")) supports.fix(node);
    plica::Scene scene{mesh, {{tissue}, {"body"}, plica::Indices::Zero(mesh.cell_count())}, supports};
    scene.velocity = plica::Points::Constant(mesh.node_count(), 3, 0.1);
    plica::Simulation simulation(std::move(scene), {});
    for (int step = 0; step < 3; ++step) {
      plica::Vector force = plica::Vector::Constant(simulation.state().displacement.size(), 1e-6);
      simulation.set_external_force(std::move(force));
      simulation.advance();
    }
    plica::State state = simulation.state();
    state.displacement.conservativeResize(3 * state.displacement.size());
    state.displacement.conservativeResize(simulation.state().displacement.size());
    const plica::Vector Ku = simulation.stiffness() * state.displacement;
    good = agrees("K u of the ledger", (Ku - state.elastic_force).norm(), 1e-12 * Ku.norm()) && good;
    simulation.restore(std::move(state));
    simulation.advance();
  }
  return good ? 0 : 1;
}

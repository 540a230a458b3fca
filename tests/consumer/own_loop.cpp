// An embedder with a mesh and a time loop of its own, who takes matrices and a solver from plica: a clamped bar
// swings freely. The trapezoidal rule conserves energy: what is lost is what the viscosity takes.
#include <cmath>
#include <iostream>
#include <plica/mesh/tet_mesh.hpp>
#include <plica/solve/krylov.hpp>
#include <plica/solve/supports.hpp>
#include <plica/tissue/assembly.hpp>

#include "bar.hpp"

using plica::Vector;

namespace {

/// M + h/2 C + h^2/4 K, the step matrix of the trapezoidal rule for the acceleration.
plica::BlockMatrix step_matrix(const plica::NodalMatrix& M, const plica::BlockMatrix& C,
                               const plica::BlockMatrix& K, double h) {
  plica::BlockMatrix A(K.pattern());
  for (std::size_t k = 0; k < A.values().size(); ++k) {
    A.values()[k] = 0.5 * h * C.values()[k] + 0.25 * h * h * K.values()[k];
  }
  for (std::ptrdiff_t entry = 0; entry < A.pattern()->entries(); ++entry) {
    for (int c = 0; c < 3; ++c) A.block(entry)[4 * c] += M.values()[static_cast<std::size_t>(entry)];
  }
  return A;
}

bool agrees(const char* what, double found, double expected, double tolerance) {
  const bool good = std::abs(found - expected) <= tolerance * std::abs(expected);
  std::cout << what << ": " << found << ", expected " << expected << (good ? "" : "  <- WRONG") << '\n';
  return good;
}

}  // namespace

int main() {
  const plica::TetMesh mesh = make_bar(8, 4);
  plica::check_mesh(mesh);

  plica::Tissue tissue;
  tissue.materials = {{plica::Isotropic{20e3, 0.3}, 1020.0, 1.0}};  // Pa, -, kg/m^3, Pa s
  tissue.names = {"body"};
  tissue.cell_material = plica::Indices::Zero(mesh.cell_count());
  tissue.validate(mesh);

  const plica::Assembler assembler(mesh);
  const plica::NodalMatrix M = assembler.mass(tissue);
  const plica::BlockMatrix C = assembler.viscosity(tissue);
  const plica::BlockMatrix K = assembler.stiffness(tissue);
  std::cout << "nodes " << mesh.node_count() << ", |M| " << M.to_sparse().norm() << " kg, |C| "
            << C.to_sparse().norm() << " N s/m, |K| " << K.to_sparse().norm() << " N/m\n";

  // The mass that the matrix holds is density times volume: 1020 kg/m^3 * 2 cm^3.
  Vector sideways = Vector::Zero(M.rows());
  for (Eigen::Index i = 2; i < sideways.size(); i += 3) sideways[i] = 1.0;
  bool good = agrees("mass, kg", sideways.dot(M * sideways), 1020.0 * 2e-6, 1e-12);  // round-off

  plica::Supports supports(mesh.node_count());
  for (const std::int32_t node : mesh.node_set("clamp")) supports.fix(node);
  const double h = 50e-6;  // s
  plica::BlockMatrix A = step_matrix(M, C, K, h);
  supports.constrain(A);
  const plica::ConjugateGradient solver(A, {1e-12, 2000});

  // At rest, and released under a shear velocity that grows towards the tip.
  Vector u = Vector::Zero(M.rows()), v = u, a = u;
  for (Eigen::Index n = 0; n < mesh.node_count(); ++n) v[3 * n + 2] = 5.0 * mesh.points(n, 0);
  supports.project(v);
  const auto energy = [&] { return 0.5 * v.dot(M * v) + 0.5 * u.dot(K * u); };
  const double start = energy();
  double lost = 0.0, largest = 0.0;

  // The first acceleration balances the forces at t = 0.
  plica::BlockMatrix M3 = step_matrix(M, C, K, 0.0);
  supports.constrain(M3);
  Vector force = -(C * v);
  supports.project(force);
  good = plica::ConjugateGradient(M3, {1e-12, 2000}).solve(force, a).converged && good;

  for (int step = 0; step < 200; ++step) {
    const Vector u_guess = u + h * v + 0.25 * h * h * a;
    const Vector v_guess = v + 0.5 * h * a;
    force = -(C * v_guess) - K * u_guess;
    supports.project(force);
    if (!solver.solve(force, a).converged) {
      std::cout << "step " << step << " did not converge\n";
      return 1;
    }
    const Vector before = v;
    u = u_guess + 0.25 * h * h * a;
    v = v_guess + 0.5 * h * a;
    const Vector mean = 0.5 * (before + v);
    lost += h * mean.dot(C * mean);
    largest = std::max(largest, u.cwiseAbs().maxCoeff());
  }
  std::cout << "largest displacement " << 1e3 * largest << " mm, lost to viscosity " << lost / start
            << " of the energy\n";
  // 200 solves to 1e-12 each leave less than 1e-9 of the energy.
  good = agrees("energy and loss, J", energy() + lost, start, 1e-9) && good;
  good = lost > 0.01 * start && largest > 1e-5 && good;
  return good ? 0 : 1;
}

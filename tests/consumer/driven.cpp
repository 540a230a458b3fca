// An embedder who lets plica step and applies a force of its own each step: the energy that the bar gains, and
// what its viscosity takes, is the work of that force, summed here from what the embedder sees.
#include <cmath>
#include <iostream>
#include <plica/dynamics/simulation.hpp>

#include "bar.hpp"

using plica::Vector;

int main() {
  const plica::TetMesh mesh = make_bar(6, 3);
  plica::Supports supports(mesh.node_count());
  for (const std::int32_t node : mesh.node_set("clamp")) supports.fix(node);
  const plica::Material tissue{plica::Isotropic{20e3, 0.3}, 1020.0, 1.0};  // Pa, -, kg/m^3, Pa s
  const plica::Scene scene{mesh, {{tissue}, {"body"}, plica::Indices::Zero(mesh.cell_count())}, supports};

  const double h = 50e-6;  // s
  plica::Simulation::Options options;
  options.scheme = plica::Newmark{0.25, 0.5};  // the trapezoidal rule: work is force at mid-step times way
  options.step = h;
  options.solver.tolerance = 1e-12;
  plica::Simulation simulation(scene, options);

  const plica::Indices& tip = mesh.node_set("tip");
  Vector before = Vector::Zero(3 * mesh.node_count());
  double work = 0.0;
  for (int step = 1; step <= 200; ++step) {
    Vector force = Vector::Zero(before.size());
    for (const std::int32_t node : tip) force[3 * node + 2] = 1e-3 * std::sin(2 * M_PI * 80.0 * step * h);  // N
    const Vector u = simulation.state().displacement;
    simulation.set_external_force(force);
    simulation.advance();
    work += 0.5 * (before + force).dot(simulation.state().displacement - u);
    before = force;
  }

  const Vector& u = simulation.state().displacement;
  const Vector& v = simulation.state().velocity;
  const double kinetic = 0.5 * v.dot(simulation.mass() * v), elastic = 0.5 * u.dot(simulation.stiffness() * u);
  const plica::Ledger& ledger = simulation.state().ledger;
  const double unexplained = kinetic + elastic + ledger.viscous_loss + ledger.numerical_loss - work;
  std::cout << "work " << work << " J, kinetic " << kinetic << " J, elastic " << elastic << " J, viscous loss "
            << ledger.viscous_loss << " J, unexplained " << unexplained << " J\n";
  // 200 solves to 1e-12 each leave less than 1e-9 of the work.
  const bool explained = std::abs(unexplained) < 1e-9 * work && ledger.viscous_loss > 0.01 * work;
  const bool without_parts = !simulation.airflow() && !simulation.collision();
  return explained && without_parts ? 0 : 1;
}

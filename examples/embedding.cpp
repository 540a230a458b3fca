// The flow through a larynx of soft tissue that is blown open, with the time loop in the caller's hands.
// tests/consumer/CMakeLists.txt shows how such a program is built against the installed library.
#include <algorithm>
#include <iostream>
#include <plica/dynamics/simulation.hpp>
#include <plica/mesh/larynx.hpp>

int main() {
  const plica::TetMesh mesh = plica::larynx_mesh(plica::Larynx::coarse());
  const plica::Material soft{plica::Isotropic{10e3, 0.4}, 1020.0, 1.0};  // Pa, -, kg/m^3, Pa s
  plica::Supports supports(mesh.node_count());
  for (const auto node : mesh.node_set("wall")) supports.fix(node);
  plica::Scene scene{mesh, {{soft}, {"soft"}, plica::Indices::Zero(mesh.cell_count())}, supports};
  scene.airflow.emplace().flow.subglottal_pressure = 800.0;  // Pa; without this line there is no airflow
  plica::Simulation simulation(scene, {plica::HilberHughesTaylor{}, 50e-6});
  double peak = 0.0;  // m^3/s
  for (; simulation.time() < 10e-3; peak = std::max(peak, simulation.record().flow->state.flow))
    simulation.advance();
  std::cout << "peak flow " << 1e6 * peak << " ml/s\n";
}

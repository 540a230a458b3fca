// An embedder who asks what can be recorded of each step, and records it by name: a larynx blown for 1 ms.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <plica/dynamics/waveforms.hpp>
#include <plica/mesh/larynx.hpp>

int main() {
  const plica::TetMesh mesh = plica::larynx_mesh(plica::Larynx::coarse());
  const plica::Material soft{plica::Isotropic{10e3, 0.4}, 1020.0, 1.0};  // Pa, -, kg/m^3, Pa s
  plica::Supports supports(mesh.node_count());
  for (const auto node : mesh.node_set("wall")) supports.fix(node);
  plica::Scene scene{mesh, {{soft}, {"soft"}, plica::Indices::Zero(mesh.cell_count())}, supports};
  scene.airflow.emplace();
  plica::Simulation simulation(scene, {plica::HilberHughesTaylor{}, 50e-6});

  std::size_t had = 0;
  bool measured = false;
  for (const plica::Waveform& waveform : plica::waveforms()) {
    if (!waveform.exists_in(scene)) continue;
    ++had;
    measured = measured || (waveform.name == "minimum_area" && waveform.unit == "m^2");
    std::cout << waveform.name << " (" << waveform.unit << "): " << waveform.meaning << '\n';
  }

  plica::Recorder all(simulation, plica::waveforms_of(scene)),
      some(simulation, {"flow", "section_area", "load_work"});
  const int steps = 20;
  double peak = 0.0;  // m^3/s
  for (int k = 0; k < steps; ++k) {
    simulation.advance();
    all.add();
    some.add();
    peak = std::max(peak, simulation.record().flow->state.flow);
  }
  const std::vector<double>& flow = some.column("flow").values;
  const double recorded = *std::max_element(flow.begin(), flow.end());
  std::cout << "peak flow " << 1e6 * peak << " ml/s, recorded " << 1e6 * recorded << " ml/s\n";
  const auto& area = some.column("section_area");
  const auto& plane = area.shape;
  const bool shaped = plane.size() == 1 && plane[0] == simulation.airflow()->sections().count() &&
                      area.values.size() == static_cast<std::size_t>(steps * plane[0]);
  const bool summed = some.column("load_work").values.back() == simulation.state().ledger.load_work;
  return measured && all.columns().size() == had && peak > 0 && recorded == peak && shaped && summed ? 0 : 1;
}

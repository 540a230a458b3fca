#pragma once
// What voices with air that remembers, in tubes or by inertia, have in common.
#include <doctest/doctest.h>

#include "reduced_scenes.hpp"

namespace scenes {

/// Folds in the flow of a viscous slit, whose air is in tubes or has inertia.
inline Scene voice(bool tubes, bool inertance) {
  Scene scene = larynx_folds();
  scene.airflow->flow.model = ViscousSlit{1.2, 1.8e-5, 3e-4, inertance};
  scene.airflow->flow.area = CutSections{8};
  if (tubes) {
    scene.airflow->tubes.trachea = Tube{{0.12}, {2e-4}, PressureSupply{0.5}, {}, 1000.0};
    scene.airflow->tubes.tract = Tube{{0.03, 0.14}, {0.6e-4, 4e-4}, Radiation{}, YieldingWall{}, 1000.0};
  }
  return scene;
}

/// W, of the air on walls that move so.
inline double power_on_walls(const FlowState& flow, const AirwayExpansion& moving) {
  return flow.subglottal_pressure * moving.below + flow.pressure.dot(moving.sections) +
         flow.supraglottal_pressure * moving.above;
}

/// Couplings and explicit steps come to the same from the voice's start at rest, without contact.
inline void check_short_steps(const Scene& voice) {
  const auto after = [&voice](Coupling coupling, TimeScheme scheme, double step, double end = 1e-3,
                              CellMass mass = CellMass::consistent) {
    Scene scene = voice;
    scene.contact.reset();
    scene.velocity.reset();
    scene.airflow->coupling = coupling;
    Simulation::Options how = options(scheme, step, 1e-12);
    how.mass = mass;
    Simulation simulation(scene, how);
    while (simulation.time() < end - 1e-9) simulation.advance();
    return simulation.displacement();
  };
  const Vector finest = after(Iterated{}, Newmark{}, 1e-5);
  const double coarse = relative(after(Iterated{}, Newmark{}, 4e-5), finest);
  CHECK(coarse < 0.03);
  CHECK(relative(after(Iterated{}, Newmark{}, 2e-5), finest) < 0.4 * coarse);
  CHECK(relative(after(Extrapolated{}, Newmark{}, 1e-5), finest) < 0.01);
  const double brief = 1e-4;
  CHECK(relative(after(Extrapolated{}, CentralDifferences{}, 4e-7, brief, CellMass::lumped),
                 after(Iterated{}, Newmark{}, 5e-6, brief, CellMass::lumped)) < 0.03);
  CHECK(relative(after(Lagged{}, Newmark{}, 1e-5), finest) < 0.05);
}

}  // namespace scenes

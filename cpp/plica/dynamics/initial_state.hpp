#pragma once
#include "plica/airflow/air_column.hpp"
#include "plica/dynamics/modal_motion.hpp"
#include "plica/dynamics/scene_loads.hpp"
#include "plica/dynamics/state.hpp"

namespace plica {

/// Displacement and velocity of a scene at t = 0, of the motion's unknowns, and what acts on it then: loads and
/// flow. Of a reduced scene those nearest to it in the span of the shapes; null where it is not, or has no air.
State initial_state(const Scene& scene, const Motion& motion, const SceneLoads& loads, AirColumn* air,
                    const ModalMotion* reduced);

}  // namespace plica

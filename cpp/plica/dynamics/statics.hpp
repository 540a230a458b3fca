#pragma once
#include "plica/dynamics/scene.hpp"

namespace plica {

/// Displacement (n, 3) m at rest under the scene's gravity and loads at t = 0, K u = f; airflow, contact and the
/// initial fields are left out. One factorisation. Throws InvalidInput where a body can move without strain.
Points equilibrium(const Scene& scene);

}  // namespace plica

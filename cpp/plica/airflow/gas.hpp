#pragma once

namespace plica {

/// Air at rest: of the flow through the glottis, and of sound in tubes.
struct Gas {
  double density = 1.23;      // kg/m^3, > 0
  double sound_speed = 350;   // m/s, > 0
  double viscosity = 1.8e-5;  // Pa s, >= 0: 1.8e-5 at 20 degrees, 1.9e-5 at 37
};

}  // namespace plica

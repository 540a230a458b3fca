#pragma once
#include "plica/tissue/internal_force.hpp"

namespace plica {

/// What a batch of cells is looked at with: u and v (3 n), v null where nothing is viscous.
struct InternalForceInput {
  const double* u;
  const double* offset;  // null where there is none
  const double* v;
  int corners;
};

/// The work on one batch, in versions of the processor (core/versions.hpp).
struct InternalForceKernel {
  using Batch = InternalForce::Batch;
  using Map = InternalForce::Map;
  /// Writes the forces of the cells' nodes, [3 node + component][lane]; viscous null where nothing is. The least J
  /// of each cell, NaN where a force is not finite.
  void (*force)(const Batch&, const Map*, const InternalForceInput&, double* elastic, double* viscous,
                double* least);
  /// J, of each cell; NaN where it is inside out at a point.
  void (*energy)(const Batch&, const Map*, const InternalForceInput&, double* energy);
};
const InternalForceKernel& internal_force_kernel();

}  // namespace plica

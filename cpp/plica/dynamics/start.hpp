#pragma once
#include <functional>
#include <optional>

#include "plica/core/block_matrix.hpp"
#include "plica/dynamics/scheme.hpp"
#include "plica/solve/krylov.hpp"
#include "plica/solve/supports.hpp"

namespace plica {

/// What a motion starts with, (3 n); docs/theory/time.md, "The first step".
struct Start {
  Vector acceleration;  // m/s^2, a_0
  /// m and m/s, U_0 - u_0 and V_0 - v_0: the elastic and viscous forces of t = 0 are those of U_0 and V_0.
  Vector displacement, velocity;
  Vector shift;  // m, added to the displacement predictor of the first step
};

/// The forces at t = 0 (N, held unknowns zero): those that wait for the motion, f_0 - K u_0, and -C v_0.
struct StartForces {
  Vector elastic_and_load, viscous;
};

/// The matrices of the motion; `supports` hold what has no acceleration at t = 0, nodes without mass included.
struct StartMatrices {
  const NodalMatrix& M;
  const std::optional<BlockMatrix>& C;
  const BlockMatrix& K;
  const Supports& supports;
};

/// m M + c C + k K with the held unknowns taken out.
BlockMatrix combine_matrices(double m, const NodalMatrix& M, double c, const std::optional<BlockMatrix>& C,
                             double k, const BlockMatrix& K, const Supports& supports);

/// The same for a motion that is solved in a way of its own.
struct StartSystem {
  using Solve = std::function<Vector(const Vector& force)>;
  std::function<Solve(double c, double k)> solver;  // of (M + c C + k K) x = force
  std::function<Vector(const Vector& a)> inertia;   // M a, held unknowns zero
};

/// A scheme with beta = gamma / 2 starts with M a_0 = f_0 - C v_0 - K u_0 and all else zero; the others carry what
/// is stiff in that a_0 into the displacements for good, so they start with the part of it that a step can
/// resolve. Throws SolveFailed.
Start start_motion(const SchemeCoefficients& scheme, double step, const StartSystem& system,
                   const StartForces& forces);
Start start_motion(const SchemeCoefficients& scheme, double step, const StartMatrices& matrices,
                   const StartForces& forces, const KrylovOptions& options);

}  // namespace plica

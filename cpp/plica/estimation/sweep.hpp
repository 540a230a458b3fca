#pragma once
#include <optional>

#include "plica/core/block_matrix.hpp"
#include "plica/solve/supports.hpp"
#include "plica/solve/triangular_factor.hpp"

namespace plica::estimation {

/// M a1 + C [(1+al) v1 - al v0] + K [(1+al) u1 - al u0] = f in steps of h, u1 = u0 + h v0 + h^2 (1/2 - beta) a0 +
/// beta h^2 a1, v1 = v0 + (1-gamma) h a0 + gamma h a1, held unknowns eliminated. What it refers to must outlive
/// it.
struct LinearMotion {
  const NodalMatrix& M;
  const std::optional<BlockMatrix>& C;  // absent where nothing is viscous
  const BlockMatrix& K;
  const Supports& supports;
  double alpha, beta, gamma;  // as of the time scheme
  double step;                // s
};

/// The derivative of K and C with respect to one parameter; the mass depends on none.
struct Direction {
  std::optional<BlockMatrix> stiffness, viscosity;
};

/// The same matrix without its blocks of zeros (a diagonal block stays): what one layer contributes is short.
BlockMatrix without_zero_blocks(const BlockMatrix& A);

/// The displacement of observed unknowns after impulses, and its exact derivatives.
///
/// Column i of `patterns` (3 n, q) is a force f (N) that acts in the first step alone, from rest: f as it stands
/// in the step's equation, at t + (1+alpha) h. Differentiated with respect to parameter j, the step reads
/// A da1 = -dK_j U - dC_j V - C dV~ - K dU~, U = (1+al) u1 - al u0, with the same A: one factorisation serves all
/// (1 + p) q columns, and as the derivatives follow one step behind, sixteen of them share each pass over it,
/// refined until every residual is `tolerance`. `plan`: that of the step's matrix, where it is known; it must hold
/// for any values of these patterns and supports (`sweep_plan`). Returns (steps, observed * (1 + p) q) row-major:
/// entry [s, o, j q + i] is the displacement (m) of unknown observed[o] at the end of step s; j = 0 the response
/// to pattern i, j > 0 its derivative along directions[j-1]. As motion and load are linear and time-invariant, the
/// response to any load of these patterns is the convolution with its waveform. O(steps (1 + p) q nnz(L)). Throws
/// InvalidInput, SolveFailed.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
RowMatrix impulse_responses(const LinearMotion& motion, const RowMatrix& patterns,
                            const std::vector<Direction>& directions, const Indices& observed,
                            std::ptrdiff_t steps, double tolerance, const FactorPlan* plan = nullptr);

/// How the step's matrix is factorised, whatever the tissue's values.
FactorPlan sweep_plan(const Pattern& pattern, const Supports& supports);

}  // namespace plica::estimation

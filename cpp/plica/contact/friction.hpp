#pragma once
#include "plica/contact/complementarity.hpp"

namespace plica {

/// Coulomb's law for r contacts of coefficient mu (-, >= 0) over a dense W (3 r, 3 r) m/N and q (3 r) m: the first
/// r rows are normal, rows r + 2 i and r + 2 i + 1 the tangents of contact i. With w = W p + q, 0 <= p_n, 0 <=
/// w_n, p_n w_n = 0; |p_t| <= mu p_n; w_t = 0 where |p_t| < mu p_n, else against p_t. Block Gauss-Seidel, each
/// contact solved exactly, from `start` (3 r), until no gap and no slip is off by more than gap_tolerance; pivots
/// counts the sweeps. Unconverged after most_sweeps. Rows that repeat others share the force (shared_compliance).
Complementarity solve_coulomb(Eigen::MatrixXd W, const Vector& q, double mu, Vector start, double gap_tolerance,
                              int most_sweeps);

}  // namespace plica

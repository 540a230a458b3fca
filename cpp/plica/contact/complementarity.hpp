#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "plica/core/types.hpp"
#include "plica/solve/shared_compliance.hpp"

namespace plica {

/// How the search for the active set ended.
struct Complementarity {
  Vector force;              // (r) p >= 0
  std::vector<char> active;  // (r) 1 where the row is closed
  int pivots = 0;            // active sets tried
  bool converged = false;
};

/// Given the active rows, returns p (zero on the others) and the residual w of every row (zero on the active).
using ActiveSolve = std::function<void(const std::vector<char>& active, Vector& p, Vector& w)>;

/// Finds p >= 0, w >= 0, p . w = 0 by block principal pivoting: all infeasible rows change sides at once; when
/// their number does not fall for three exchanges, the last infeasible row alone does (Murty's rule, finite
/// for positive definite problems) until it falls. `active` is the first guess. w counts as >= 0 above
/// -gap_tolerance.
/// Ends unconverged after most_pivots >= 1 active sets.
Complementarity pivot(std::vector<char> active, const ActiveSolve& solve, double gap_tolerance, int most_pivots);

/// 0 <= p, 0 <= w = W p + q, p . w = 0 for a dense W (r, r) m/N and q (r) m; a solution exists where W is
/// symmetric positive semi-definite, and is looked for otherwise. Rows that repeat others share the force
/// (shared_compliance).
Complementarity solve_complementarity(const Eigen::MatrixXd& W, const Vector& q, std::vector<char> guess,
                                      double gap_tolerance, int most_pivots);

}  // namespace plica

#pragma once
#include <memory>

#include "plica/contact/complementarity.hpp"
#include "plica/contact/pairs.hpp"
#include "plica/solve/compliance.hpp"
#include "plica/solve/krylov.hpp"
#include "plica/solve/supports.hpp"

namespace plica {

/// The gaps of pairs as linear functions of the positions: gap(x) = direction . (x_s - sum_k w_k x_k) + constant.
struct LinearGaps {
  std::vector<Vector3> direction;  // (pairs)
  Vector free;                     // (pairs) m, without contact forces
};

/// How contact forces and the motion they cause are computed from the step's linear system
/// A (a - a_free) = N^T p with x = x_free + scale (a - a_free), A symmetric positive definite; the columns of N^T
/// push along the pairs' normals, the rows of G are the linear gaps' directions. Implementations: condensed
/// (compliance of the surface nodes, kept) and Krylov (the thesis's GMRES).
class ContactPath {
 public:
  virtual ~ContactPath() = default;

  /// Forces p with 0 <= p, 0 <= gaps.free + scale G A^-1 N^T p + p / stiffness, complementary (N; a pair of
  /// stiffness 0 is exact). `guess` says which pairs start closed. Unconverged where most_pivots active sets hold
  /// none.
  virtual Complementarity solve(const std::vector<Pair>& pairs, const LinearGaps& gaps, double scale,
                                std::vector<char> guess, double gap_tolerance, int most_pivots) = 0;
  /// Positions of the surface nodes under the forces last solved for: x = x_free + scale A^-1 N^T p.
  virtual void move(const std::vector<Pair>& pairs, const Vector& force, double scale, const Points& x_free,
                    Points& x) = 0;
};

/// The compliance A^-1 of the surface nodes, a column when it is first needed and then for good; a dense
/// complementarity problem over the pairs. Cost of a call: O(pairs^3 / 6) plus columns * surface nodes.
std::unique_ptr<ContactPath> condensed_path(const BlockMatrix& A, const Supports& supports, const Indices& nodes,
                                            const KrylovOptions& options);

/// Paper A's solver: GMRES on the saddle point (Eq. 25 at n + 1, scaled symmetric) with the block-diagonal
/// preconditioner of Eq. (29); rows that depend on others share the force, as in the condensed path.
std::unique_ptr<ContactPath> gmres_path(const BlockMatrix& A, const Supports& supports, const Indices& nodes,
                                        const KrylovOptions& options);

}  // namespace plica

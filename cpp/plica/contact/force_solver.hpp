#pragma once
#include <memory>

#include "plica/contact/complementarity.hpp"
#include "plica/contact/enforcement.hpp"
#include "plica/contact/row.hpp"
#include "plica/mesh/mirror.hpp"
#include "plica/solve/compliance.hpp"
#include "plica/solve/factorization.hpp"
#include "plica/solve/krylov.hpp"
#include "plica/solve/supports.hpp"

namespace plica {

/// How contact forces and the motion they cause are computed from the step's linear system
/// A (a - a_free) = N^T p with x = x_free + scale (a - a_free), A symmetric positive definite; the columns of N^T
/// are what the rows push, the rows of G how their gaps move. Implementations: condensed (compliance of the
/// surface nodes, kept), saddle point (preconditioned with what is known of A), the thesis's GMRES, and direct.
class ForceSolver {
 public:
  virtual ~ForceSolver() = default;

  /// Forces p with 0 <= p, 0 <= free + scale G A^-1 N^T p + compliance p, complementary (N). `guess` says which
  /// rows start closed. Unconverged where most_pivots active sets hold none.
  virtual Complementarity solve(const std::vector<Row>& rows, double scale, std::vector<char> guess,
                                double gap_tolerance, int most_pivots) = 0;
  /// W = scale G A^-1 N^T + diag(compliance), (rows, rows) m/N, which friction needs. The condensed solver has it;
  /// the others throw InvalidInput.
  virtual Eigen::MatrixXd compliance(const std::vector<Row>& rows, double scale);
  /// Positions of the surface nodes under the forces last solved for: x = x_free + scale A^-1 N^T p.
  virtual void move(const std::vector<Row>& rows, const Vector& force, double scale, const Points& x_free,
                    Points& x) = 0;
  /// m, how far the last move() has shifted any node at most, where that is known without positions.
  virtual double shifted() const { return 0.0; }
  /// Adds A^-1 N^T p of the forces last solved for to a (3 n), as far as it is known, f = N^T p (3 n) N: a start
  /// for the solve of A a = f + N^T p from a_free. What is added may be off: only the solve's cost depends on it.
  virtual void add_response(const Vector& /*force*/, Vector& /*a*/) const {}
  /// Forgets earlier solutions, so that what follows depends on what is asked alone.
  virtual void forget() {}
};

/// What Automatic stands for; another solver stays as it is. Condensed for up to 5000 surface nodes, Saddle above:
/// a node that touches costs three columns, about as much as the step of a collision without them, so columns pay
/// where nodes touch more often than once, and their memory grows with surface nodes times all nodes.
ContactSolver chosen_solver(const ContactSolver& solver, std::ptrdiff_t surface_nodes);
/// "auto", "condensed", "saddle" or "gmres", as scene files have it.
const char* name_of(const ContactSolver& solver);

/// The one that is chosen, Automatic for what it stands for. A, the step's linear solver for it and the supports
/// must outlive it and not change. `options`: of those that are Krylov methods themselves.
std::unique_ptr<ForceSolver> force_solver(const ContactSolver& solver, const BlockMatrix& A,
                                          const LinearSolver& linear, const Supports& supports,
                                          const Indices& nodes, const KrylovOptions& options);

/// The compliance A^-1 of the surface nodes, a column when it is first needed and then for good; a dense
/// complementarity problem over the rows. Columns are solved for as positions within a step
/// are, see LinearSolver. Cost of a call: O(rows^3 / 6) plus columns * surface nodes.
std::unique_ptr<ForceSolver> condensed_solver(const LinearSolver& A, const Supports& supports,
                                              const Indices& nodes);

/// The saddle point of every active set by conjugate gradients with a constraint preconditioner (SaddlePoint),
/// warm-started from the active set before; nothing is kept from step to step. Cost of an active set: about that
/// of one solve with A.
std::unique_ptr<ForceSolver> saddle_solver(const BlockMatrix& A, const Supports& supports, const Indices& nodes,
                                           const KrylovOptions& options);

/// Paper A's solver: GMRES on the saddle point (Eq. 25 at n + 1, scaled symmetric) with the block-diagonal
/// preconditioner of Eq. (29); rows that depend on others share the force, as in the condensed solver.
std::unique_ptr<ForceSolver> gmres_solver(const BlockMatrix& A, const Supports& supports, const Indices& nodes,
                                          const KrylovOptions& options);

/// Where nothing moves within the step and every row has a compliance: p = max(0, -free / compliance), A and scale
/// having no part in it.
std::unique_ptr<ForceSolver> explicit_solver();

/// For one configuration of an A that iterations are slow on, as in statics: a factorisation, and a
/// back-substitution for each row of each call. A must outlive it.
std::unique_ptr<ForceSolver> direct_solver(const Factorization& A, const Supports& supports, const Indices& nodes);

/// For rows on all `nodes` of a symmetric body: a solver on the nodes of the part that is solved for, what it is
/// asked and what it answers folded and spread. Forces and accelerations of add_response are the part's. `images`
/// must outlive it.
std::unique_ptr<ForceSolver> mirrored_solver(std::unique_ptr<ForceSolver> part, const MirrorImages& images,
                                             const Indices& nodes);

}  // namespace plica

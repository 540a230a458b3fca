#pragma once
#include <variant>

namespace plica {

/// Condensed or Saddle, whichever suits the number of surface nodes (path.hpp: chosen_solver).
struct Automatic {};
/// Compliance of the surface nodes, computed once, then a dense complementarity problem a step.
struct Condensed {};
/// Conjugate gradients on the saddle point of each active set, with a constraint preconditioner: nothing is
/// computed once or kept.
struct Saddle {};
/// The thesis's GMRES on the saddle point with the block-diagonal preconditioner of Eq. (29).
struct Gmres {};

using ContactSolver = std::variant<Automatic, Condensed, Saddle, Gmres>;

/// Gaps are closed at x_{n+1}.
struct EndOfStep {};
/// Gaps are closed at (1 + alpha) x_{n+1} - alpha x_n, as Eq. (25) is printed: x_{n+1} overshoots.
struct Weighted {};

/// Exact contact by Lagrange multipliers (Paper A, Eqs. 21 and 25), one compressive force a slave node.
struct Multipliers {
  ContactSolver solver = Automatic{};
  std::variant<EndOfStep, Weighted> position = EndOfStep{};
};

/// Node-to-surface penalty (Paper A, Eq. 22): a slave node at gap g < 0 is pushed with -stiffness * g.
/// Implicit: the force belongs to the end of the step.
struct Penalty {
  double stiffness = 100.0;  // N/m a node, > 0
};

/// The thesis's penalty (Paper A, Eq. 28): each inverted airway tetrahedron of volume V < 0 pushes its slave
/// node with -kappa V / 4, a third of it back on each node of the master face (printed: all of it on each).
struct VolumePenalty {
  double kappa = 1e8;  // N/m^3, > 0; the thesis's 1e7 dyn/cm^3
};

using Enforcement = std::variant<Multipliers, Penalty, VolumePenalty>;

}  // namespace plica

#pragma once
#include <variant>

#include "plica/core/types.hpp"

namespace plica {

/// Condensed or Saddle, whichever suits the number of surface nodes (force_solver.hpp: chosen_solver).
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
using GapPosition = std::variant<EndOfStep, Weighted>;

/// Exact contact by Lagrange multipliers (Paper A, Eqs. 21 and 25), one compressive force a slave node.
struct Multipliers {
  ContactSolver solver = Automatic{};
  GapPosition position = EndOfStep{};
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

/// Multipliers found by Uzawa's iteration (Paper B, Eqs. 9 and 10, corrected: they stay compressive and do not
/// double). A slave node at gap g is pushed with p = max(0, lambda - stiffness * g), implicit; each augmentation
/// takes p for the next lambda. lambda is carried from step to step.
struct Augmented {
  double stiffness = 1.0;      // N/m a node, > 0; where a step starts. Paper B: 1 dyn/cm, 1e-3 N/m
  double growth = 10.0;        // -, > 1: factor of the stiffness where an augmentation did too little
  double reduction = 0.75;     // -, in (0, 1): share by which it has to lower the largest gap error
  int max_augmentations = 50;  // >= 1; a step keeps the gaps that are left then. Paper B shows 4
};

/// Nitsche's method, the variant without symmetry: a slave node at gap g under the tissue's own normal stress
/// sigma is pushed with p = area max(0, -gamma g - sigma), implicit. Consistent: the motion of exact contact has
/// it, so no penetration is needed for a force. gamma = factor times the stiffness of
/// a layer of tissue one mean edge thick, its inertia within a step included.
struct Nitsche {
  double factor = 10.0;  // -, > 0; too small has no solution, large is a penalty
};

using Enforcement = std::variant<Multipliers, Penalty, VolumePenalty, Augmented, Nitsche>;

/// Gaps are held at the slave nodes (Paper A, Eqs. 18-20); six-node faces are four flat triangles.
struct AtNodes {};
/// Gaps are held in the mean around each slave node, and forces spread by the faces' own shape functions: right on
/// six-node faces and between meshes that do not match.
struct Mortar {
  Faces first, second;  // (f, 3) or (f, 6), whose flat triangles are those of the airway
};
using FaceMethod = std::variant<AtNodes, Mortar>;

/// Coulomb's law between the surfaces: |p_t| <= coefficient p_n, against the slip of the step.
struct Friction {
  double coefficient;  // -, > 0
};

}  // namespace plica

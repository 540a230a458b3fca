#pragma once
#include "plica/dynamics/scene.hpp"

namespace plica {

/// Tissue that has been stretched to another shape, in equilibrium there.
struct Posture {
  Points displacement;  // (n, 3) m, from rest
  int parts = 0;        // of the way, that were taken one by one
  int iterations = 0;   // of Newton's method in all
};

/// The equilibrium of the mesh's tissue (StretchLaw) where what is held has been moved by `held` (n, 3) m, whose
/// other entries are not read. The way from rest is taken in parts, held nodes, the active stress and all:
/// Newton's method with its exact slope, which is positive definite all the way. Throws InvalidInput for a mesh
/// that is stretched already, SolveFailed naming the part of the way at which a cell turns inside out or the
/// tissue gives way (buckles).
Posture stretched(const TetMesh& mesh, const Tissue& tissue, const Supports& supports, const Points& held);

}  // namespace plica

#pragma once
#include <functional>

#include "plica/dynamics/scene.hpp"

namespace plica {

/// Tissue that has been stretched to another shape, in equilibrium there.
struct Posture {
  Points displacement;  // (n, 3) m, from rest
  int parts = 0;        // of the way, that were taken one by one
  int iterations = 0;   // of Newton's method in all
};

/// (n, 3) m, from rest: where what is held is at a share of the way, 0 at rest (all zero) to 1. Other entries are
/// not read.
using HeldAt = std::function<Points(double)>;

/// The equilibrium of the mesh's tissue (StretchLaw) where what is held has been moved to held(1). The way from
/// rest is taken in parts, the active stress in shares of it: Newton's method with its exact slope, which has to
/// be positive definite wherever it is looked at. Throws InvalidInput for a mesh that is stretched already,
/// SolveFailed naming the part of the way at which a cell is inverted or the tissue gives way (buckles).
Posture stretched(const TetMesh& mesh, const Tissue& tissue, const Supports& supports, const HeldAt& held);

}  // namespace plica

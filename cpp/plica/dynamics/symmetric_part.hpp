#pragma once
#include "plica/dynamics/scene.hpp"
#include "plica/mesh/mirror.hpp"

namespace plica {

/// The part of a symmetric scene's tissue that is solved for, held in the planes across them: the rest moves as
/// its mirror images. Flow and contact see all of it.
struct SymmetricPart {
  /// The scene has a symmetry. Throws InvalidInput naming what is not symmetric, and for what cannot be solved so.
  explicit SymmetricPart(const Scene& scene);

  MirrorImages images;
  TetMesh mesh;
  Tissue tissue;
  Supports supports;
};

}  // namespace plica

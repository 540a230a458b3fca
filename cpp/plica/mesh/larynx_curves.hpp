#pragma once
#include "plica/mesh/larynx_quadrant.hpp"

namespace plica {

/// By how much the middle of each edge of the quadrant is off its chord, in the plane of its height.
struct LarynxCurves {
  std::vector<Edge> edges;
  std::vector<Vector3> bend;
  std::vector<char> surface;  // of the airway or of the wall
};

/// Those of the airway's ellipses, of the wall's cylinder, and of what lies between by its depth; straightened
/// until no cell's det dx/dxi falls anywhere below a tenth of the straight cell's, sides inside first.
LarynxCurves larynx_curves(const LarynxQuadrant& quadrant);

}  // namespace plica

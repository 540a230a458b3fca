#pragma once
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

/// What a node may do while a mesh is smoothed.
struct Freedom {
  Vector3 along = Vector3::Zero();  // 1 for each axis it may move along, 0 for each it may not
  double cylinder = 0;              // m, radius about the z axis on which it stays; 0: on none
};

/// Moves the nodes one after another to where the sum of the inverse cubed mean ratios of their linear cells is
/// least, sum 1 / v^2 with v = 6 V / (l^2)^(3/2), l^2 the sum of squared edges: `sweeps` times. While a cell is
/// inside out, v is replaced by (v + sqrt(v^2 + 4 d^2)) / 2, which is positive, d^2 = e (e - least v), e = 1e-3
/// (Escobar et al. 2003); once all are positive they stay so.
void smooth_mesh(Points& x, const Cells& cells, const std::vector<Freedom>& freedom, int sweeps);

}  // namespace plica

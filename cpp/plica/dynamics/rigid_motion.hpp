#pragma once
#include <vector>

#include "plica/mesh/tet_mesh.hpp"
#include "plica/solve/supports.hpp"

namespace plica {

/// A motion without strain that the supports leave to a body.
struct RigidMotion {
  std::int32_t body = 0;             // its lowest node, see body_of_nodes
  Vector3 centre = Vector3::Zero();  // m, the mean of its nodes
  bool turns = false;                // else it shifts
  bool unheld = false;               // whether nothing of the body is held, so that all its motions are free
  Vector3 along = Vector3::Zero();   // unit vector of the shift, or of the turn's axis through the centre
};

/// One for each body that can move without strain, ascending by body.
std::vector<RigidMotion> rigid_motions(const TetMesh& mesh, const Supports& supports);

}  // namespace plica

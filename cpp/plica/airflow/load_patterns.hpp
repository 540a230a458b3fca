#pragma once
#include <Eigen/SparseCore>

#include "plica/airflow/flow_model.hpp"
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

/// The load of pressures on the surface at rest, linear in them: (3 nodes) N, three components a node, is
/// below * p_below + sections * p + above * p_above.
struct LoadPatterns {
  Eigen::SparseMatrix<double, Eigen::RowMajor> sections;  // (3 nodes, s) m^2, of 1 Pa at one section
  Vector below, above;  // (3 nodes) m^2, of 1 Pa below the first section, above the last
  /// How fast the airway gives way at the nodes' velocity (3 nodes) m/s: the load's power is that times pressures.
  AirwayExpansion expansion(const Vector& velocity) const;
};

/// Column i is -int N_l phi_i(z) n dA with phi_i linear in z between sections, 1 at section i: over the curved
/// face with six nodes in 64 parts of six points each, exact where phi_i is linear in a part. So the work of the
/// load is that of the pressures on the volume swept in each phi_i, and together the columns load the whole
/// surface exactly. `faces` are rows of the nodes that the rows of the patterns belong to; x (n, 3) m of those
/// nodes. Heights ascend; a node up to `same` beyond the first or the last section is at it.
LoadPatterns load_patterns(const Points& x, const Faces& faces, const Vector& height, double same);

}  // namespace plica

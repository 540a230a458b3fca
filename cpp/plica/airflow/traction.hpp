#pragma once
#include "plica/core/types.hpp"

namespace plica {

/// A value (3 or 6) or a vector (3 or 6, 3) at each node of one face; never on the heap.
using FaceValues = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 6, 1>;
using FaceVectors = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor, 6, 3>;

/// Consistent nodal forces F_l = -int p n N_l dA (N) of one face at positions x, with n the outward normal
/// and p = sum_k p_k N_k (Pa). Three nodes: Paper A, Eq. (17). Six nodes: the curved isoparametric face,
/// integrated exactly, so a closed surface under constant pressure has neither force nor moment.
FaceVectors pressure_load(const FaceVectors& x, const FaceValues& pressure);

}  // namespace plica

#pragma once
#include "plica/core/types.hpp"

namespace plica {

struct Eigenpairs {
  Vector values;            // in ascending order
  Eigen::MatrixXd vectors;  // one a column, orthonormal
};

/// A v = lambda v of a symmetric matrix, of which the lower triangle is read.
/// Eigen's solver in one place: each source that names it compiles it anew, for five seconds.
Eigenpairs symmetric_eigenpairs(const Eigen::MatrixXd& A);

}  // namespace plica

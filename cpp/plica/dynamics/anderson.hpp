#pragma once
#include "plica/core/types.hpp"

namespace plica {

/// Anderson mixing for a fixed point x = H(x) of few unknowns: the next x is the affine combination of the
/// last images H(x_k) whose residuals H(x_k) - x_k cancel best. The first step is the plain one.
class Anderson {
 public:
  explicit Anderson(int depth) : depth_(depth) {}
  /// Takes x and its image, returns the next x.
  Vector next(const Vector& x, const Vector& image);
  void forget();

 private:
  int depth_;
  std::vector<Vector> images_, residuals_;  // newest last
};

}  // namespace plica

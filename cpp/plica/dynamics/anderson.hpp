#pragma once
#include "plica/airflow/secant.hpp"

namespace plica {

/// Anderson mixing for a fixed point x = H(x) of few unknowns: the next x is the affine combination of the
/// last images H(x_k) whose residuals H(x_k) - x_k cancel best. The first step is the plain one, where no
/// differences of a problem before it are at hand.
class Anderson {
 public:
  explicit Anderson(int depth) : depth_(depth) {}
  /// Takes x and its image, returns the next x.
  Vector next(const Vector& x, const Vector& image);
  /// Takes a difference of a problem before this one, for as long as it has none of its own.
  void take(Secant difference);
  void forget();

 private:
  int depth_;
  bool taken_ = false;               // what differences_ are
  Vector image_, residual_;          // of the last x; empty before
  std::vector<Secant> differences_;  // newest last
};

}  // namespace plica

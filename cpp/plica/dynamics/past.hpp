#pragma once
#include "plica/core/types.hpp"
#include "plica/solve/linear_solver.hpp"

namespace plica {

/// The accelerations a of the last steps, newest first, and A a of each, A the step matrix: the next solve with A
/// starts from them.
struct Past {
  static constexpr std::size_t depth = 8;
  std::vector<Vector> accelerations, images;  // (3 n)

  void add(Vector acceleration, Vector image);
  /// Their combination x that leaves least of A x = b, with A x.
  Guess nearest(const Vector& b) const;
};

}  // namespace plica

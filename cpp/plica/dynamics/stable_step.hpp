#pragma once
#include <functional>
#include <optional>

#include "plica/core/block_matrix.hpp"

namespace plica {

/// How long a step central differences take (docs/theory/explicit.md): the largest eigenvalue of
/// M^-1 (h C + h^2 / 4 K) must stay below 1, M lumped.
class StableStep {
 public:
  /// N, elastic K x + viscous C x of x (3 n).
  using Slopes = std::function<Vector(const Vector& x, double elastic, double viscous)>;
  /// Of matrices, which must outlive them; C is absent where no material is viscous.
  static Slopes slopes_of(const BlockMatrix& K, const std::optional<BlockMatrix>& C);
  /// inverse_mass (3 n) 1/kg, zero where held.
  StableStep(const Vector& inverse_mass, Slopes slopes);

  /// That eigenvalue from above, within 1 %: by Lanczos' method from a random start, which misses it with a
  /// probability below 1e-9. Some 150 products with either matrix.
  double eigenvalue(double h) const;
  /// s, the largest h with eigenvalue(h) + h^2 / 4 further <= 1; `further` (1/s^2) of stiffness beside K.
  double largest(double further = 0.0) const;

 private:
  Vector product(const Vector& x, double h) const;

  Vector scale_;  // (3 n) M^-1/2
  Slopes slopes_;
};

}  // namespace plica

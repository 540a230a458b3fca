#pragma once
#include "plica/contact/row.hpp"

namespace plica {

/// The tissue's normal stress at the nodes of a surface, as Nitsche's method sees it: linear in the positions.
/// Whoever knows the tissue and the step hands it in.
class NormalStress {
 public:
  virtual ~NormalStress() = default;
  /// Pa, n . sigma n where the nodes are at x; n (unit).
  virtual double at(std::int32_t node, const Vector3& n, const Points& x) const = 0;
  /// Its derivatives, Pa/m.
  virtual std::vector<NodeVector> slopes(std::int32_t node, const Vector3& n) const = 0;
  /// Pa, stiffness of the tissue along n: n . S(n n).
  virtual double modulus(std::int32_t node, const Vector3& n) const = 0;
};

}  // namespace plica

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
  /// Pa/m, the pressure that a layer of this depth (m) under the node answers a unit motion along n with, within
  /// the step: its elasticity and its inertia.
  virtual double stiffness(std::int32_t node, const Vector3& n, double depth) const = 0;
};

}  // namespace plica

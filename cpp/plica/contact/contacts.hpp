#pragma once
#include <utility>
#include <vector>

#include "plica/contact/constraint.hpp"

namespace plica {

/// The contact forces of one configuration, and how they were found.
struct Contacts {
  std::vector<Constraint> constraints;
  /// As last solved for: the constraints' normals, then, with friction, two tangents for each.
  std::vector<Row> rows;
  Vector force;            // (rows) N, >= 0 on normals; the multiplier of Paper A is its negative
  int passes = 0;          // linearisations of the constraints
  int pivots = 0;          // active sets (with friction: sweeps) tried, over all passes
  int augmentations = 0;   // of Uzawa's iteration
  double gap_error = 0.0;  // m, largest left
  bool converged = true;   // false where passes or augmentations left a gap error above the tolerance
  bool facing = false;     // whether nodes were held apart from those they face at rest (FacingNodes)
  bool any_force() const { return force.size() > 0 && force.maxCoeff() > 0; }
  /// Adds the forces on all nodes to `nodal` (3 n).
  void add_forces(Vector& nodal) const;
  /// Place of a key among the constraints, or -1.
  std::ptrdiff_t place_of(std::int32_t key) const;
  /// N, zero where there is no constraint of this key.
  double force_of(std::int32_t key) const;
  /// What carries force, keys ascending, and its forces (N).
  std::pair<std::vector<std::int32_t>, Vector> closed() const;
};

}  // namespace plica

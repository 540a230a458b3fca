#pragma once
#include <vector>

#include "plica/core/types.hpp"
#include "plica/solve/supports.hpp"

namespace plica {

/// One contact force p (N, >= 0) and what it holds back: a row of G beside its column of N^T. Under p the nodes of
/// `push` feel p times their vectors; gap(x) = sum over `gap` of vector . x_node + a constant, and
/// gap + compliance p >= 0, p >= 0, with one of the two zero.
struct Row {
  std::vector<NodeVector> push;  // -
  std::vector<NodeVector> gap;   // -
  double free = 0.0;             // m, gap without contact forces
  double compliance = 0.0;       // m/N, >= 0; 0: exact

  /// The part of the gap that moves with x, m.
  double moving(const Points& x) const {
    double sum = 0.0;
    for (const auto& [node, vector] : gap) sum += vector.dot(x.row(node).transpose());
    return sum;
  }
  /// The same of a nodal vector (3 n).
  double along(const Vector& v) const {
    double sum = 0.0;
    for (const auto& [node, vector] : gap) sum += vector.dot(v.segment<3>(3 * node));
    return sum;
  }
  /// Adds the force p (N) on all sides to `force` (3 n).
  void add_force(double p, Vector& force) const {
    for (const auto& [node, vector] : push) force.segment<3>(3 * node) += p * vector;
  }
};

/// (rows) m, their gaps without contact forces.
Vector free_gaps(const std::vector<Row>& rows);

/// The rows with the components of held unknowns set to zero.
std::vector<Row> without_held(std::vector<Row> rows, const Supports& supports);

}  // namespace plica

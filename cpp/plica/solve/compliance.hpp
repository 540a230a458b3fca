#pragma once
#include "plica/solve/linear_solver.hpp"
#include "plica/solve/supports.hpp"

namespace plica {

/// Columns of A^-1 for single unknowns, restricted to chosen nodes, computed when first asked for and kept.
/// Row r of a column belongs to unknown 3 * nodes[r / 3] + r % 3. Deterministic: a column does not depend on
/// when, or with which others, it was computed.
class Compliance {
 public:
  /// nodes: the nodes that results are wanted at and that columns may be asked for. Fixed unknowns have
  /// zero columns. A, the solver's matrix, is constrained by the supports; the solver must outlive this.
  Compliance(const LinearSolver& A, const Supports& supports, Indices nodes, double tolerance);

  const Indices& nodes() const { return nodes_; }
  /// Makes sure that the three columns of each of these nodes (positions in nodes()) exist. Throws SolveFailed,
  /// with the node and component, where a column does not reach the tolerance.
  void require(const std::vector<std::int32_t>& local_nodes);
  /// (3 nodes) displacement of all nodes under a unit force on component c of a node; must exist.
  const double* column(std::int32_t local_node, int component) const;
  /// A force on one of the nodes, N.
  struct Force {
    std::int32_t local_node;
    Vector3 force;
  };
  /// Adds A^-1 of these forces to a (3 n) at all nodes of the mesh, in single precision and without what is below
  /// `farthest` of a column's largest entry: a start for a solve. The columns must exist.
  void add_response(const std::vector<Force>& forces, Vector& a) const;

 private:
  /// A column at all nodes of the mesh where it is felt.
  struct Response {
    std::vector<std::int32_t> node;
    std::vector<Eigen::Vector3f> value;
  };
  static constexpr double farthest = 1e-9;                  // single precision limits a start to some 1e-8
  static constexpr std::size_t batch = LinearSolver::pack;  // columns solved together: bounds the memory

  void check_local(std::int32_t local_node) const;
  void solve(const std::vector<std::int32_t>& columns);  // local unknowns, at most `batch`

  Supports supports_;
  Indices nodes_;
  const LinearSolver& solver_;
  double tolerance_;
  std::ptrdiff_t unknowns_;
  std::vector<std::vector<double>> columns_;  // (3 nodes) each empty or (3 nodes)
  std::vector<Response> responses_;           // (3 nodes)
};

}  // namespace plica

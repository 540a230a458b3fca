#pragma once
#include <vector>

#include "plica/tissue/assembly.hpp"

namespace plica {

/// Stress at nodes as a linear function of the motion around them: S eps(u) + eta eps(v) of the cells that have
/// the node, each taken at the node, averaged by volume. Voigt order xx yy zz xy yz zx.
class NodeStress {
 public:
  using Slope = Eigen::Matrix<double, 6, 3>;
  struct Term {
    std::int32_t node;
    Slope elastic;  // Pa/m
    Slope viscous;  // Pa s/m
  };

  /// nodes: those that the stress is wanted at. O(cells).
  NodeStress(const TetMesh& mesh, const Tissue& tissue, const std::vector<std::int32_t>& nodes);

  /// The nodes whose motion the stress at `node` depends on, ascending.
  const std::vector<Term>& at(std::int32_t node) const { return terms_[static_cast<std::size_t>(node)]; }
  /// Pa, n . S(n n) averaged as the stress is: what a unit stretch along n (unit) answers.
  double modulus(std::int32_t node, const Vector3& n) const;
  /// kg/m^3, averaged as the stress is.
  double density(std::int32_t node) const { return density_[static_cast<std::size_t>(node)]; }

 private:
  std::vector<std::vector<Term>> terms_;  // (n), empty at other nodes
  std::vector<Matrix6> elasticity_;       // (n), Pa, zero at other nodes
  std::vector<double> density_;           // (n), kg/m^3, zero at other nodes
};

/// n n in Voigt order, so that n . sigma n is its dot product with the stress.
Vector6 normal_dyad(const Vector3& n);

}  // namespace plica

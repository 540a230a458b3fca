#pragma once
#include <optional>
#include <vector>

#include "plica/tissue/assembly.hpp"

namespace plica {

/// The force that tissue at finite strain holds its nodes with, without its slope: int P grad N dV over the shape
/// at rest (docs/theory/finite_strain.md), at the points where Assembler::stretched looks, P = P_e + P_v with P_e
/// that of StretchLaw and P_v = J sigma F^-T of Cauchy's sigma = eta d, d the rate of strain. Linear about u = 0
/// it is K u + C v of the Assembler. Displacements count from mesh.points.
class InternalForce {
 public:
  /// Keeps what it needs of both. Throws InvalidInput for tissue that StretchLaw does not take. O(cells).
  InternalForce(const TetMesh& mesh, const Tissue& tissue);

  /// N, (3 n) each.
  struct Force {
    Vector elastic, viscous;  // viscous: empty where no material is
  };
  /// At displacement u and velocity v (3 n) m, m/s; v is not looked at where no material is viscous. Returns the
  /// lowest cell that is inside out at a point, or whose force is not finite; the force is then none. Threaded,
  /// the same for any number of threads.
  std::optional<std::int32_t> at(const Vector& u, const Vector& v, Force& force) const;
  /// J, the energy of the law; NaN where a cell is inside out at a point.
  double energy(const Vector& u) const;
  bool viscous() const { return viscous_; }

  static constexpr int lanes = 8;  // cells that a kernel takes together
  /// Cells that are taken together; what there is of each cell lies side by side.
  struct Batch {
    std::int32_t cell[lanes];      // its number; the last one again where there are too few, without volume
    std::int32_t node[10][lanes];  // of its corners and mid-sides
    /// mu, lambda, beta, 2 (mu' - mu), e - 4 (mu' - mu), E', 4 k, s, m, eta, the fibre's components.
    double law[13][lanes];
    std::ptrdiff_t map;  // the first of its maps
    bool curved, stiffens, matrix_stiffens, pulls;
  };
  /// dxi/dX (row xi_k = l_{k+1}, column X) and the volume of a cell where its sides are straight, of a point where
  /// not.
  struct Map {
    double inverse[9][lanes];
    double volume[lanes];
  };

 private:
  std::ptrdiff_t nodes_;
  int corners_;  // of the field of gradients: 1 where it is the same all over a cell, or 4
  bool viscous_ = false;
  Vector offset_;  // (3 n) m, from rest to mesh.points; empty where that is none
  std::vector<Batch> batches_;
  std::vector<Map> maps_;
  std::vector<std::int32_t> first_,
      place_;  // of each node: where its forces lie, place_[first_[i]] to first_[i + 1]
};

}  // namespace plica

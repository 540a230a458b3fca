#pragma once
#include "plica/core/block_matrix.hpp"
#include "plica/solve/supports.hpp"
#include "plica/tissue/internal_force.hpp"

namespace plica {

/// Tissue at finite strain: its force is that of StretchLaw at the whole deformation, from rest, and of the
/// viscosity there (InternalForce); docs/theory/finite_strain.md. Without: linear about the shape of the mesh.
struct FiniteStrain {
  /// -, > 0: what may be left out of balance in a step, of the tissue's force then, in the Euclidean norm.
  double tolerance = 1e-4;
  int max_iterations = 60;  // >= 1, of a step
  void validate() const;    // throws InvalidInput
};

/// By what the force of tissue at finite strain differs from the K u + C v of a motion, which has the slope at its
/// origin: r = f(u, v) - K u - C v, a load that depends on the motion.
class ExcessForce {
 public:
  /// `copies`: of the mesh in the whole. All must outlive it.
  ExcessForce(const FiniteStrain& options, const TetMesh& mesh, const Tissue& tissue, const BlockMatrix& stiffness,
              const std::optional<BlockMatrix>& viscosity, const Supports& supports, int copies);

  /// N, (3 n) each.
  struct Force {
    Vector elastic;          // f_e - K u
    Vector viscous;          // f_v - C v; empty where no material is viscous
    double whole = 0.0;      // N, |f| on what is not held
    double round_off = 0.0;  // N, what is left of sums that cancel
    Vector sum() const { return viscous.size() > 0 ? Vector(elastic + viscous) : elastic; }
  };
  /// Returns the cell that has none (InternalForce::at).
  std::optional<std::int32_t> at(const Vector& u, const Vector& v, Force& force) const;
  /// J, of all copies; NaN where a cell is inside out.
  double energy(const Vector& u) const { return copies_ * force_.energy(u); }

  const FiniteStrain& options() const { return options_; }
  std::string cell_text(std::int32_t cell) const;
  std::string node_text(std::ptrdiff_t unknown) const;

 private:
  FiniteStrain options_;
  const TetMesh& mesh_;
  const BlockMatrix& stiffness_;
  const std::optional<BlockMatrix>& viscosity_;
  const Supports& supports_;
  int copies_;
  InternalForce force_;
  double held_;  // N, norm of the sums of stress that cancel at the origin
};

}  // namespace plica

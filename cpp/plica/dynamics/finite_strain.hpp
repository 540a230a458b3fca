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
  /// Of a scene's motion at t = 0. Throws InvalidInput where a cell has none.
  Force at_start(const Vector& u, const Vector& v) const;
  /// N, f_e at u. Throws SolveFailed where a cell has none.
  Vector elastic(const Vector& u) const;
  /// N, elastic K x + viscous C x with the slopes of f_e on u and of f_v on v at u, held = elastic(u): by the
  /// difference of forces, to some 1e-6 of it. Throws SolveFailed.
  Vector slopes(const Vector& u, const Vector& held, const Vector& x, double elastic, double viscous) const;
  /// J, of all copies; NaN where a cell is inside out.
  double energy(const Vector& u) const { return copies_ * force_.energy(u); }

  const FiniteStrain& options() const { return options_; }
  const TetMesh& mesh() const { return mesh_; }
  const Tissue& tissue() const { return tissue_; }
  /// Where a cell has no force in whatever state a step can reach.
  [[noreturn]] void fail_inside_out(std::int32_t cell, const std::string& how) const;
  std::string cell_text(std::int32_t cell) const;
  std::string node_text(std::ptrdiff_t unknown) const;

 private:
  FiniteStrain options_;
  const TetMesh& mesh_;
  const Tissue& tissue_;
  const BlockMatrix& stiffness_;
  const std::optional<BlockMatrix>& viscosity_;
  const Supports& supports_;
  int copies_;
  InternalForce force_;
  double held_;    // N, norm of the sums of stress that cancel at the origin
  double little_;  // m, hardly a strain of any cell
};

}  // namespace plica

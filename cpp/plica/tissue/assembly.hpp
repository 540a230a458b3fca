#pragma once
#include <array>

#include "plica/core/block_matrix.hpp"
#include "plica/core/error.hpp"
#include "plica/mesh/tet_mesh.hpp"
#include "plica/tissue/material.hpp"

namespace plica {

/// One material a (layer, side), or as the caller groups cells.
struct Tissue {
  std::vector<Material> materials;
  std::vector<std::string> names;  // one a material, for messages: "cover.left"
  Indices cell_material;           // (m) position in materials
  void validate(const TetMesh& mesh) const;
};

/// How the mass of a cell lies on its nodes: int rho N_a N_b dV, or on the diagonal alone (docs/theory/tissue.md).
enum class CellMass { consistent, lumped };

/// What is to have no mass, and what moves: marks of the nodes (n each).
struct MassTransfer {
  std::vector<char> massless;
  std::vector<char> held;  // in all components; none of these is massless
  std::vector<char> free;  // of bodies that can move without strain: they keep all moments of their mass
};

/// A cell of stretched tissue is inside out.
struct CellInverted : SolveFailed {
  using SolveFailed::SolveFailed;
};

/// Assembles M, C and K of one mesh straight into their final pattern. O(cells); the mesh must outlive it. Of a
/// stretched mesh M is that at rest, as mass is conserved, C that of its shape, and K the slope of the force at
/// its shape (StretchLaw).
class Assembler {
 public:
  explicit Assembler(const TetMesh& mesh);

  const Pattern& pattern() const { return pattern_; }
  NodalMatrix mass(const Tissue& tissue) const;  // consistent, kg
  /// (n) kg a node: Element::lumped_mass summed.
  Vector lumped_mass(const Tissue& tissue) const;
  /// The mass matrix without mass at massless nodes. What they had is with the nodes behind them, so that the
  /// moving mass of every body is as it was and, of free ones, centre of mass and tensor of inertia too; positive
  /// definite on the other nodes. Throws InvalidInput naming the body that is too thin for that
  /// (docs/theory/massless.md).
  NodalMatrix redistributed_mass(const Tissue& tissue, CellMass kind, const MassTransfer& transfer) const;
  BlockMatrix stiffness(const Tissue& tissue) const;  // N/m
  /// The force (3 n) N that stretched tissue, at rest in mesh.rest or where that is empty in mesh.points, holds
  /// nodes at x (n, 3) m with, and its slope. Throws CellInverted.
  struct Stretched {
    Vector force;
    BlockMatrix slope;
  };
  Stretched stretched(const Tissue& tissue, const Points& x) const;
  /// (m, 6) Pa, Cauchy stress of the cells of the stretched mesh (at their middles), xx yy zz xy yz zx.
  Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor> stress(const Tissue& tissue) const;
  BlockMatrix viscosity(const Tissue& tissue) const;  // N s/m
  /// (3 n) N: consistent load of a force per mass (m/s^2), e.g. gravity.
  Vector body_force(const Tissue& tissue, const Vector3& acceleration) const;
  /// (3 n) N: consistent load of a constant traction (Pa) on faces of the reference surface.
  Vector traction(const Faces& faces, const Vector3& traction) const;

 private:
  friend class AffineStiffness;
  // scatter map: for each cell, its node pairs' positions in the pattern
  const TetMesh& mesh_;
  Pattern pattern_;
  std::vector<std::int32_t> scatter_;  // (m * npe * npe)
};

/// K and C as sums over material coefficients: a new material costs one pass over the values, no assembly.
class AffineStiffness {
 public:
  /// Cells are grouped as in `tissue`; only its fibre directions and grouping are used. 6 K_c and one C a group.
  AffineStiffness(const Assembler& assembler, const Tissue& tissue);
  /// coefficients (groups, 6) Pa; equal to Assembler::stiffness to round-off.
  BlockMatrix stiffness(const Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>& coefficients) const;
  BlockMatrix viscosity(const Vector& viscosities) const;  // (groups) Pa s

 private:
  struct Group {
    std::vector<std::int32_t> entries;             // positions in the pattern that the group touches
    std::array<std::vector<double>, 6> stiffness;  // (9 * entries) each
    std::vector<double> viscosity;                 // (9 * entries)
  };
  Pattern pattern_;
  std::vector<Group> groups_;
};

}  // namespace plica

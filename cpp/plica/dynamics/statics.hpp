#pragma once
#include "plica/dynamics/scene.hpp"
#include "plica/tissue/internal_force.hpp"

namespace plica {

/// Displacement (n, 3) m at rest under the scene's gravity and loads at t = 0, airflow, contact and the initial
/// fields left out: K u = f, one factorisation, or at finite strain f(u) = f (StretchedStatics), the loads in
/// shares of them (walk). Throws InvalidInput where a body can move without strain, SolveFailed as walk() does.
Points equilibrium(const Scene& scene);

/// Tissue at finite strain under the scene's gravity and loads at t = 0, with the force that its time steps have.
class StretchedStatics {
 public:
  /// The scene must outlive it. Throws InvalidInput where a body can move without strain.
  explicit StretchedStatics(const Scene& scene);
  StretchedStatics(const StretchedStatics&) = delete;
  StretchedStatics& operator=(const StretchedStatics&) = delete;

  /// (3 n) N: a share of the load less what the tissue, displaced by u (3 n) m, holds its nodes with
  /// (InternalForce); zero where nodes are held. Throws CellInverted.
  Vector unbalanced(const Vector& u, double share = 1.0) const;
  /// N/m: slope of that force, with the held unknowns. Throws CellInverted.
  BlockMatrix slope(const Vector& u) const;

 private:
  const Scene& scene_;
  const Assembler assembler_;
  const InternalForce force_;
  Vector load_;
};

/// Rest in contact.
struct ContactEquilibrium {
  Points displacement;               // (n, 3) m
  Vector contact_force;              // (3 n) N
  Vector contact_pressure;           // (n) Pa, see Collision::pressure
  std::vector<std::int32_t> closed;  // keys of the constraints that carry force, ascending
  int passes = 0, pivots = 0;        // see Contacts
};
/// As equilibrium(), with the scene's contact, and with held unknowns at the scene's initial displacement: what is
/// pressed together is moved there. One factorisation, and a back-substitution for each constraint and pass.
/// A solver that the contact names, and its position within a step, are left out. Throws InvalidInput where there
/// is no contact and for Nitsche's method, SolveFailed as Collision does and where augmentations run out.
ContactEquilibrium contact_equilibrium(const Scene& scene);

}  // namespace plica

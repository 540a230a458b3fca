#pragma once
#include "plica/dynamics/scene.hpp"

namespace plica {

/// Displacement (n, 3) m at rest under the scene's gravity and loads at t = 0, K u = f; airflow, contact and the
/// initial fields are left out. One factorisation. Throws InvalidInput where a body can move without strain.
Points equilibrium(const Scene& scene);

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

#pragma once
#include <functional>

#include "plica/airflow/air_column.hpp"
#include "plica/contact/constraint.hpp"
#include "plica/dynamics/first_signs.hpp"
#include "plica/dynamics/ledger.hpp"
#include "plica/dynamics/past.hpp"
#include "plica/tissue/strain.hpp"

namespace plica {

/// A look at the whole tissue of a reduced motion.
struct Watched {
  Strains strains;
  Indices inverted_by_layer;  // (layers) cells
};

/// After so many steps the products of a state are made from its motion, which takes their round-off away.
inline constexpr int steps_between_products = 64;

/// Everything the next step, or what is said of it, depends on. Nodal vectors are (3 n), in a reduced motion (r)
/// of its coordinates; contact_force is empty where the scene has no contact, flow_load where it has no airflow,
/// those of the viscosity where no material is viscous; explicit steps have no K v, K a, C v, C a and no past.
struct State {
  std::int64_t step = 0;
  Vector displacement, velocity, acceleration;  // m, m/s, m/s^2
  Vector load, contact_force;                   // N, as they entered the last step's equation
  Vector flow_load;                             // N, what of `load` is the airflow's
  Vector elastic_force, weighted_elastic_force, viscous_force, inertial_force;  // K u, K U, C V, M a
  Vector stiffness_velocity, stiffness_acceleration;                            // K v, K a
  Vector viscosity_velocity, viscosity_acceleration;                            // C v, C a
  Vector elastic_excess,
      viscous_excess;                // N, ExcessForce of the last step's equation; empty where tissue is linear
  Past past;                         // this state's acceleration first
  Vector interface_force;            // N, reduced: the contact force on the contact's own nodes; else empty
  std::optional<Watched> watched;    // reduced: the last look
  std::vector<std::int32_t> closed;  // keys of the contact constraints that carried force, ascending
  Vector closed_force;               // (closed) N, the normal forces of these
  double depth = 0.0;                // m, >= 0: deepest penetration of a node
  AirColumn::Memory air;
  /// W, of the airflow (FlowState) in the last step
  double supplied_power = 0.0, viscous_power = 0.0, inertial_power = 0.0;
  Ledger ledger;
  FirstSigns first_signs;  // of trouble since t = 0: no step depends on them, a failure's text does

  /// Of a reduced motion: its contact, for Collision::pressure.
  Contact contact_at_interface() const { return {interface_force, closed, closed_force}; }
  /// What the states of a scene have in common.
  struct Shape {
    std::ptrdiff_t unknowns, cells, layers;
    bool viscous, airflow;
    /// Whether its contact can have a constraint of this key; empty without.
    std::function<bool(std::int32_t)> knows;
    std::ptrdiff_t interface = -1;  // reduced: unknowns of the contact's own nodes, else -1
    bool solves = true;             // the step's linear systems: explicit ones keep nothing for the next
    bool finite_strain = false;
  };
  /// Throws InvalidInput where a part has another size, is not finite or cannot be in this scene.
  void validate(const Shape& shape) const;
};

}  // namespace plica

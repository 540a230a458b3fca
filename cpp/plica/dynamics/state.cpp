#include "plica/dynamics/state.hpp"

#include <cmath>

#include "plica/core/error.hpp"

namespace plica {

void State::validate(const Shape& shape) const {
  const std::pair<const char*, const Vector*> fields[] = {{"displacement", &displacement},
                                                          {"velocity", &velocity},
                                                          {"acceleration", &acceleration},
                                                          {"load", &load},
                                                          {"contact_force", &contact_force},
                                                          {"interface_force", &interface_force},
                                                          {"flow_load", &flow_load},
                                                          {"elastic_force", &elastic_force},
                                                          {"weighted_elastic_force", &weighted_elastic_force},
                                                          {"viscous_force", &viscous_force},
                                                          {"inertial_force", &inertial_force},
                                                          {"stiffness_velocity", &stiffness_velocity},
                                                          {"stiffness_acceleration", &stiffness_acceleration},
                                                          {"viscosity_velocity", &viscosity_velocity},
                                                          {"viscosity_acceleration", &viscosity_acceleration},
                                                          {"elastic_excess", &elastic_excess},
                                                          {"viscous_excess", &viscous_excess}};
  for (const auto& [name, values] : fields) {
    const bool viscous = values == &viscous_force || values == &viscosity_velocity ||
                         values == &viscosity_acceleration || values == &viscous_excess;
    const bool excess = values == &elastic_excess || values == &viscous_excess;
    const bool absent = (values == &contact_force && !shape.knows) || (values == &flow_load && !shape.airflow) ||
                        (viscous && !shape.viscous) || (excess && !shape.finite_strain) ||
                        (!shape.solves && (values == &stiffness_velocity || values == &stiffness_acceleration ||
                                           values == &viscosity_velocity || values == &viscosity_acceleration));
    const bool reduced = shape.interface >= 0, own = values == &interface_force;
    const std::ptrdiff_t size = absent ? 0 : !own ? shape.unknowns : reduced ? shape.interface : 0;
    if (values->size() != size)
      throw InvalidInput("Simulation", std::string("size of the state's ") + name,
                         static_cast<double>(values->size()), "", std::to_string(size),
                         "It belongs to another scene.");
    if (!values->allFinite())
      throw InvalidInput(std::string("Simulation: the state's ") + name + " has a value that is not finite.");
  }
  const std::size_t past_steps = past.accelerations.size();
  if (shape.interface >= 0 || !shape.solves
          ? past_steps > 0
          : past_steps == 0 || past_steps > Past::depth || past.images.size() != past_steps)
    throw InvalidInput("Simulation", "state's past accelerations", static_cast<double>(past_steps), "",
                       "1 to " + std::to_string(Past::depth) + ", with as many images");
  for (const auto* vectors : {&past.accelerations, &past.images})
    for (const Vector& values : *vectors)
      if (values.size() != shape.unknowns || !values.allFinite())
        throw InvalidInput("Simulation: the state's past must be finite and of this scene's " +
                           std::to_string(shape.unknowns) + " unknowns.");
  if (!shape.knows && (!closed.empty() || depth != 0))
    throw InvalidInput("Simulation: the state has closed constraints; the scene must have contact.");
  if (!shape.airflow && (supplied_power != 0 || viscous_power != 0 || inertial_power != 0))
    throw InvalidInput("Simulation: the state has powers of the air; the scene must have airflow.");
  if (step < 0) throw InvalidInput("Simulation", "state's step", static_cast<double>(step), "", ">= 0");
  if (closed_force.size() != static_cast<std::ptrdiff_t>(closed.size()))
    throw InvalidInput("Simulation", "size of the state's closed_force", static_cast<double>(closed_force.size()),
                       "", "that of closed, " + std::to_string(closed.size()));
  for (std::size_t i = 0; i < closed.size(); ++i)
    if (!(closed_force[static_cast<std::ptrdiff_t>(i)] > 0) || (i && closed[i] <= closed[i - 1]))
      throw InvalidInput("Simulation: the state's closed constraints must ascend, each with a force > 0 N.");
  if (shape.knows)
    for (const std::int32_t key : closed)
      if (!shape.knows(key))
        throw InvalidInput("Simulation", "state's closed constraint", key, "", "one that this contact can have",
                           "It belongs to another scene.");
  if (!(depth >= 0) || !std::isfinite(depth))
    throw InvalidInput("Simulation", "state's depth", depth, "m", ">= 0 and finite");
  if (!std::isfinite(supplied_power) || !std::isfinite(viscous_power) || !std::isfinite(inertial_power))
    throw InvalidInput("Simulation: the state's supplied_power, viscous_power and inertial_power must be finite.");
  if (closed.empty() && contact_force.size() > 0 && !contact_force.isZero(0))
    throw InvalidInput(
        "Simulation: the state has contact forces; must have the closed constraints that carry them.");
  for (const double energy :
       {ledger.kinetic, ledger.elastic, ledger.load_work, ledger.flow_work, ledger.contact_work,
        ledger.viscous_loss, ledger.numerical_loss, ledger.nonlinear_loss, ledger.initial,
        ledger.air_supplied_energy, ledger.air_viscous_energy, ledger.air_inertial_energy})
    if (!std::isfinite(energy)) throw InvalidInput("Simulation: the state's ledger must be finite.");
  if (watched &&
      (watched->inverted_by_layer.size() != shape.layers || (watched->inverted_by_layer.array() < 0).any()))
    throw InvalidInput("Simulation: the state's inverted cells must be numbers >= 0 of this scene's " +
                       std::to_string(shape.layers) + " layers.");
  first_signs.validate(step, shape.cells);
}

}  // namespace plica

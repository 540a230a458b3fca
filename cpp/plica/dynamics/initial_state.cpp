#include "plica/dynamics/initial_state.hpp"

namespace plica {

State initial_state(const Scene& scene, const Motion& motion, const SceneLoads& loads, AirColumn* air,
                    const ModalMotion* reduced) {
  const std::ptrdiff_t unknowns = motion.stiffness().rows();
  const auto given = [&](const std::optional<Points>& field, const char* name) -> Vector {
    if (!field) return Vector::Zero(unknowns);
    Vector values = as_vector(*field);
    scene.supports.project(values);
    return motion.images() ? motion.images()->part_of(values, name, scene.mesh.points) : values;
  };
  State state;
  state.displacement = given(scene.displacement, "the initial displacement (m)");
  state.velocity = given(scene.velocity, "the initial velocity (m/s)");
  if (scene.contact) state.contact_force = Vector::Zero(unknowns);
  state.load = loads.at(0.0);
  if (reduced) {  // what the coordinates make of it
    state.displacement = reduced->at_unknowns(reduced->nearest(state.displacement));
    state.velocity = reduced->at_unknowns(reduced->nearest(state.velocity));
  }
  if (air) {  // whose flow knows the scene's coordinates
    const Airflow& airflow = air->airflow();
    const Points x = scene.mesh.points + as_points(motion.everywhere(state.displacement));
    const FlowState flow = air->start(airflow.areas(x));
    state.flow_load = Vector::Zero(x.size());
    airflow.add_load(x, flow.on_walls(), state.flow_load);
    state.flow_load = motion.folded(std::move(state.flow_load));
    state.load += state.flow_load;
    state.air = air->remembered();
    state.supplied_power = flow.supplied_power;
    state.viscous_power = flow.viscous_power;  // steady: nothing is accelerated
  }
  return state;
}

}  // namespace plica

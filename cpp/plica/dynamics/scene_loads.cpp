#include "plica/dynamics/scene_loads.hpp"

#include <cmath>

namespace plica {

SceneLoads::SceneLoads(const Scene& scene, const Assembler& assembler)
    : loads_(scene.loads), constant_(Vector::Zero(3 * scene.mesh.node_count())) {
  for (const Load& load : loads_)
    amplitudes_.push_back(assembler.traction(scene.mesh.surface(load.surface), load.traction));
  if (scene.gravity) constant_ = assembler.body_force(scene.tissue, *scene.gravity);
}

void SceneLoads::reduce(const Eigen::MatrixXd& shapes) {
  for (Vector* load : {&constant_, &external_})
    if (load->size()) *load = shapes.transpose() * *load;
  for (Vector& amplitude : amplitudes_) amplitude = shapes.transpose() * amplitude;
}

Vector SceneLoads::at(double t) const {
  constexpr double pi = 3.14159265358979323846;
  Vector load = constant_;
  for (std::size_t i = 0; i < loads_.size(); ++i)
    load += std::cos(2 * pi * loads_[i].frequency * t + loads_[i].phase) * amplitudes_[i];
  if (external_.size()) load += external_;
  return load;
}

}  // namespace plica

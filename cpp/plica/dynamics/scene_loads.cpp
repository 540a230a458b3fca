#include "plica/dynamics/scene_loads.hpp"

#include <cmath>

#include "plica/core/constants.hpp"

namespace plica {

SceneLoads::SceneLoads(const Scene& scene, const SymmetricPart* part, const Assembler& assembler)
    : loads_(scene.loads), constant_(Vector::Zero(3 * assembler.pattern()->rows())) {
  if (loads_.empty() && !scene.gravity) return;
  const auto assemble = [&](const Assembler& whole, const auto& as_unknowns) {
    for (const Load& load : loads_)
      amplitudes_.push_back(as_unknowns(whole.traction(scene.mesh.surface(load.surface), load.traction),
                                        "the load on " + load.surface + " (N)"));
    if (scene.gravity) constant_ = as_unknowns(whole.body_force(scene.tissue, *scene.gravity), "the weight (N)");
  };
  if (part)
    assemble(Assembler(scene.mesh), [&](const Vector& force, const std::string& name) {
      return part->images.folded_symmetric(force, name, scene.mesh.points);
    });
  else
    assemble(assembler, [](Vector force, const std::string&) { return force; });
}

void SceneLoads::reduce(const Eigen::MatrixXd& shapes) {
  for (Vector* load : {&constant_, &external_})
    if (load->size()) *load = shapes.transpose() * *load;
  for (Vector& amplitude : amplitudes_) amplitude = shapes.transpose() * amplitude;
}

Vector SceneLoads::at(double t) const {
  Vector load = constant_;
  for (std::size_t i = 0; i < loads_.size(); ++i)
    load += std::cos(2 * pi * loads_[i].frequency * t + loads_[i].phase) * amplitudes_[i];
  if (external_.size()) load += external_;
  return load;
}

}  // namespace plica

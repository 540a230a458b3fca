#include "dynamics_scene.hpp"

namespace plica::python {

Supports to_supports(const Held& fixed, std::ptrdiff_t nodes) {
  if (fixed.ndim() != 2 || fixed.shape(0) != nodes || fixed.shape(1) != 3)
    wrong_shape("Scene", "fixed", fixed, "(" + std::to_string(nodes) + ", 3)");
  Supports supports(nodes);
  for (std::int32_t i = 0; i < nodes; ++i)
    for (int c = 0; c < 3; ++c)
      if (fixed.at(i, c)) supports.fix(i, c);
  return supports;
}

Scene make_scene(const TetMesh& mesh, std::vector<Material> materials, std::vector<std::string> names,
                 const py::array& cell_material, const Held& fixed, std::vector<Load> loads,
                 const std::optional<Vec3>& gravity) {
  Scene scene{mesh,
              {std::move(materials), std::move(names), to_indices(cell_material, "Scene", "cell_material")},
              to_supports(fixed, mesh.node_count()),
              std::nullopt,
              std::nullopt,
              std::move(loads),
              std::nullopt,
              std::nullopt,
              std::nullopt};
  if (gravity) scene.gravity = Vector3((*gravity)[0], (*gravity)[1], (*gravity)[2]);
  return scene;
}

}  // namespace plica::python

#pragma once
#include <array>

#include "arrays.hpp"
#include "plica/dynamics/scene.hpp"

// What a simulation and an equilibrium are given alike.
namespace plica::python {

/// (n, 3) which components of nodes are held.
using Held = py::array_t<bool, pybind11::array::c_style | pybind11::array::forcecast>;
using Vec3 = std::array<double, 3>;

Supports to_supports(const Held& fixed, std::ptrdiff_t nodes);

/// Mesh, tissue, supports, loads and gravity of a scene; nothing else.
Scene make_scene(const TetMesh& mesh, std::vector<Material> materials, std::vector<std::string> names,
                 const py::array& cell_material, const Held& fixed, std::vector<Load> loads,
                 const std::optional<Vec3>& gravity);

}  // namespace plica::python

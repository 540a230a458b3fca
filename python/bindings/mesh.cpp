#include "arrays.hpp"
#include "engine.hpp"
#include "options.hpp"
#include "plica/mesh/block.hpp"
#include "plica/mesh/larynx.hpp"
#include "plica/mesh/tet_mesh.hpp"

namespace plica::python {

/// Left out, the thesis's sections.
template <>
struct Shown<std::vector<Larynx::Section>> {
  using Given = std::optional<RealArray>;
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

  static std::vector<Larynx::Section> take(const Given& rows, const char* owner, const char* option) {
    if (!rows) return Larynx{}.sections;
    if (rows->ndim() != 2 || rows->shape(1) != 2) wrong_shape(owner, option, *rows, "(k, 2): z, minor");
    std::vector<Larynx::Section> sections;
    for (py::ssize_t k = 0; k < rows->shape(0); ++k) sections.push_back({rows->at(k, 0), rows->at(k, 1)});
    return sections;
  }
  static py::array_t<double> show(const std::vector<Larynx::Section>& sections) {
    Rows rows(static_cast<Eigen::Index>(sections.size()), 2);
    for (Eigen::Index k = 0; k < rows.rows(); ++k) {
      const auto& section = sections[static_cast<std::size_t>(k)];
      rows.row(k) << section.z, section.minor;
    }
    return give(std::move(rows));
  }
  static Given initial(const std::vector<Larynx::Section>&) { return std::nullopt; }
};

}  // namespace plica::python

using namespace plica;
using namespace plica::python;

namespace {

using Released = py::gil_scoped_release;

std::unique_ptr<TetMesh> make_mesh(const RealArray& points, const py::array& cells,
                                   const std::optional<py::array>& cell_layer,
                                   const std::optional<py::array>& cell_side, std::vector<std::string> layer_names,
                                   const std::map<std::string, py::array>& surfaces,
                                   const std::map<std::string, py::array>& node_sets) {
  const std::string where = "TetMesh";
  auto mesh = std::make_unique<TetMesh>();
  mesh->points = to_points(points, where, "points");
  mesh->cells = to_rows(cells, {4, 10}, where, "cells");
  mesh->layer_names = std::move(layer_names);
  const auto labels = [&](const std::optional<py::array>& given, const std::string& name) {
    if (!given) return Indices();
    if (given->size() != mesh->cell_count()) {
      wrong_shape(where, name, *given, "(" + std::to_string(mesh->cell_count()) + ",)");
    }
    return to_indices(*given, where, name);
  };
  mesh->cell_layer = labels(cell_layer, "cell_layer");
  mesh->cell_side = labels(cell_side, "cell_side");
  *mesh = labelled(std::move(*mesh));
  check_nodes(mesh->cells, mesh->node_count(), where, "cell");
  for (const auto& [name, faces] : surfaces) {
    const std::string label = "surfaces[\"" + name + "\"]";
    mesh->surfaces[name] = to_rows(faces, {mesh->order() == 2 ? 6 : 3}, where, label);
    check_nodes(mesh->surfaces[name], mesh->node_count(), where, label + " face");
  }
  for (const auto& [name, nodes] : node_sets) {
    const std::string label = "node_sets[\"" + name + "\"]";
    mesh->node_sets[name] = to_indices(nodes, where, label);
    check_nodes(mesh->node_sets[name], mesh->node_count(), where, label + " entry");
  }
  return mesh;
}

using NamedArrays = py::typing::Dict<py::str, py::array_t<std::int32_t>>;

template <typename Map>
NamedArrays views(const Map& map, const py::handle& owner) {
  NamedArrays out;
  for (const auto& [name, matrix] : map) {
    out[py::str(name)] = view(matrix, owner);
  }
  return out;
}

void bind_tet_mesh(py::module_& engine) {
  py::class_<TetMesh, std::shared_ptr<TetMesh>>(engine, "TetMesh")
      .def(py::init(&make_mesh), py::arg("points"), py::arg("cells"), py::arg("cell_layer") = py::none(),
           py::arg("cell_side") = py::none(), py::arg("layer_names") = py::list(),
           py::arg("surfaces") = py::dict(), py::arg("node_sets") = py::dict())
      .def_property_readonly("points", [](py::object self) { return view(self.cast<TetMesh&>().points, self); })
      .def_property_readonly("cells", [](py::object self) { return view(self.cast<TetMesh&>().cells, self); })
      .def_property_readonly("cell_layer",
                             [](py::object self) { return view(self.cast<TetMesh&>().cell_layer, self); })
      .def_property_readonly("cell_side",
                             [](py::object self) { return view(self.cast<TetMesh&>().cell_side, self); })
      .def_property_readonly("layer_names", [](const TetMesh& mesh) { return mesh.layer_names; })
      .def_property_readonly("surfaces",
                             [](py::object self) { return views(self.cast<TetMesh&>().surfaces, self); })
      .def_property_readonly("node_sets",
                             [](py::object self) { return views(self.cast<TetMesh&>().node_sets, self); })
      .def_property_readonly("order", &TetMesh::order);

  engine.def("to_quadratic", &to_quadratic, py::arg("mesh"), py::call_guard<Released>());
  engine.def("check_mesh", &check, py::arg("mesh"), py::call_guard<Released>());
  engine.def(
      "boundary",
      [](const py::array& cells) {
        Boundary found;
        const Cells rows = to_rows(cells, {4, 10}, "boundary", "cells");
        {
          const Released released;
          found = boundary(rows);
        }
        return std::make_tuple(give(std::move(found.faces)), give(std::move(found.cell_of_face)));
      },
      py::arg("cells"));
  engine.def(
      "flat_triangles",
      [](const py::array& faces) {
        return give(flat_triangles(to_rows(faces, {3, 6}, "flat_triangles", "faces")));
      },
      py::arg("faces"));
  engine.def(
      "signed_volumes",
      [](const RealArray& points, const py::array& cells) {
        const Points x = to_points(points, "signed_volumes", "points");
        const Cells rows = to_rows(cells, {4, 10}, "signed_volumes", "cells");
        check_nodes(rows, x.rows(), "signed_volumes", "cell");
        return give(signed_volumes(x, rows));
      },
      py::arg("points"), py::arg("cells"));
}

const auto& larynx_options() {
  static const auto table = options<Larynx>(
      "Larynx", option("sections", &Larynx::sections), option("major", &Larynx::major),
      option("radius", &Larynx::radius), option("layer_thickness", &Larynx::layer_thickness),
      option("layers_from_section", &Larynx::layers_from_section),
      option("layers_to_section", &Larynx::layers_to_section), option("levels", &Larynx::levels),
      option("around", &Larynx::around), option("cover_rings", &Larynx::cover_rings),
      option("ligament_rings", &Larynx::ligament_rings), option("body_rings", &Larynx::body_rings));
  return table;
}

py::dict larynx_fields(const Larynx& larynx) { return larynx_options().to_dict(larynx); }

void bind_larynx(py::module_& engine) {
  larynx_options().def(engine, "larynx_mesh", [](const Larynx& larynx) {
    const Released released;
    return larynx_mesh(larynx);
  });
  engine.def("larynx_defaults", [] { return larynx_fields(Larynx{}); });
  engine.def(
      "larynx_preset",
      [](const std::string& name) {
        if (name == "coarse") {
          return larynx_fields(Larynx::coarse());
        }
        if (name == "demo") {
          return larynx_fields(Larynx::demo());
        }
        if (name == "medium") {
          return larynx_fields(Larynx::medium());
        }
        if (name == "thesis") {
          return larynx_fields(Larynx::thesis());
        }
        throw InvalidInput("larynx_preset: name = \"" + name + "\"; must be coarse, demo, medium or thesis.");
      },
      py::arg("name"));
}

void bind_block(py::module_& engine) {
  const Block defaults;
  engine.def(
      "block_mesh",
      [](const std::array<double, 3>& corner, const std::array<double, 3>& size,
         const std::array<int, 3>& divisions) {
        return block_mesh(Block{corner, size, divisions});
      },
      py::arg("corner") = defaults.corner, py::arg("size") = defaults.size,
      py::arg("divisions") = defaults.divisions, py::call_guard<Released>());
  engine.def("combine", &combine, py::arg("first"), py::arg("second"), py::arg("first_prefix") = "a.",
             py::arg("second_prefix") = "b.", py::call_guard<Released>());
}

}  // namespace

void bind_mesh(py::module_& engine) {
  bind_tet_mesh(engine);
  bind_larynx(engine);
  bind_block(engine);
}

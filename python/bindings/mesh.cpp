#include "arrays.hpp"
#include "engine.hpp"
#include "plica/mesh/block.hpp"
#include "plica/mesh/jacobian.hpp"
#include "plica/mesh/larynx.hpp"
#include "plica/mesh/larynx_parts.hpp"
#include "plica/mesh/tet_mesh.hpp"

using namespace plica;
using namespace plica::python;

namespace {

using Released = py::gil_scoped_release;

std::unique_ptr<TetMesh> make_mesh(const RealArray& points, const py::array& cells,
                                   const std::optional<py::array>& cell_layer,
                                   const std::optional<py::array>& cell_side, std::vector<std::string> layer_names,
                                   const std::map<std::string, py::array>& surfaces,
                                   const std::map<std::string, py::array>& node_sets,
                                   const std::optional<RealArray>& rest) {
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
  if (rest) mesh->rest = to_points(*rest, where, "rest");
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
           py::arg("surfaces") = py::dict(), py::arg("node_sets") = py::dict(), py::arg("rest") = py::none())
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
      .def_property_readonly("rest",
                             [](py::object self) -> std::optional<py::array_t<double>> {
                               const auto& mesh = self.cast<TetMesh&>();
                               if (!mesh.stretched()) return std::nullopt;
                               return view(mesh.rest, self);
                             })
      .def_property_readonly("order", &TetMesh::order);

  engine.def("to_quadratic", &to_quadratic, py::arg("mesh"), py::call_guard<Released>());
  engine.def(
      "least_jacobian_ratios",
      [](const RealArray& points, const py::array& cells) {
        const Points x = to_points(points, "least_jacobian_ratios", "points");
        const Cells rows = to_rows(cells, {4, 10}, "least_jacobian_ratios", "cells");
        check_nodes(rows, x.rows(), "least_jacobian_ratios", "cell");
        return give(least_jacobian_ratios(x, rows));
      },
      py::arg("points"), py::arg("cells"));
  engine.def(
      "body_of_nodes", [](const TetMesh& mesh) { return give(body_of_nodes(mesh)); }, py::arg("mesh"));
  engine.def("check_mesh", &check_mesh, py::arg("mesh"), py::call_guard<Released>());
  engine.def(
      "boundary",
      [](const py::array& cells) {
        Boundary found;
        const Cells rows = to_rows(cells, {4, 10}, "boundary", "cells");
        {
          const Released released;
          found = boundary_of(rows);
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

using SectionRows = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

SectionRows section_rows(const std::vector<Larynx::Section>& sections) {
  SectionRows rows(static_cast<Eigen::Index>(sections.size()), 2);
  for (Eigen::Index k = 0; k < rows.rows(); ++k) {
    const auto& section = sections[static_cast<std::size_t>(k)];
    rows.row(k) << section.z, section.minor;
  }
  return rows;
}

std::vector<Larynx::Section> to_sections(const RealArray& rows) {
  if (rows.ndim() != 2 || rows.shape(1) != 2) {
    wrong_shape("Larynx", "sections", rows, "(k, 2): z, minor");
  }
  std::vector<Larynx::Section> sections;
  for (py::ssize_t k = 0; k < rows.shape(0); ++k) {
    sections.push_back({rows.at(k, 0), rows.at(k, 1)});
  }
  return sections;
}

std::string layers_along_name(Larynx::LayersAlong along) {
  return along == Larynx::LayersAlong::level ? "level" : "normal";
}

Larynx::LayersAlong to_layers_along(const std::string& name) {
  if (name == "level") return Larynx::LayersAlong::level;
  if (name == "normal") return Larynx::LayersAlong::normal;
  throw InvalidInput("Larynx: layers_along = \"" + name + "\"; must be level or normal.");
}

/// Fields of the shape, and of how it is meshed: `levels` tells levels from a triangulated section.
py::dict larynx_fields(const Larynx& larynx) {
  py::dict fields;
  fields["sections"] = give(section_rows(larynx.shape.sections));
  fields["major"] = larynx.shape.major;
  fields["radius"] = larynx.shape.radius;
  fields["layer_thickness"] = larynx.shape.layer_thickness;
  fields["layers_from_section"] = larynx.shape.layers_from_section;
  fields["layers_to_section"] = larynx.shape.layers_to_section;
  fields["layers_along"] = layers_along_name(larynx.shape.layers_along);
  if (const auto* how = std::get_if<Larynx::Levels>(&larynx.meshed)) {
    fields["levels"] = how->levels;
    fields["around"] = how->around;
    fields["cover_rings"] = how->cover_rings;
    fields["ligament_rings"] = how->ligament_rings;
    fields["body_rings"] = how->body_rings;
  } else {
    const auto& triangulated = std::get<Larynx::Triangulated>(larynx.meshed);
    fields["size"] = triangulated.size;
    fields["growth"] = triangulated.growth;
    fields["tip_cut"] = triangulated.tip_cut;
    fields["around"] = triangulated.around;
  }
  return fields;
}

using Preset = Larynx (*)();
const std::map<std::string, Preset> presets = {{"coarse", Larynx::coarse},
                                               {"demo", Larynx::demo},
                                               {"fine", Larynx::fine},
                                               {"finest", Larynx::finest},
                                               {"thesis", Larynx::thesis},
                                               {"thesis_coarse", Larynx::thesis_coarse},
                                               {"thesis_demo", Larynx::thesis_demo},
                                               {"thesis_medium", Larynx::thesis_medium}};

void bind_larynx(py::module_& engine) {
  engine.attr("DEEPEST_LAYER") = deepest_layer;
  const Larynx::Shape shape;
  const Larynx::Triangulated by_size;
  const Larynx::Levels by_level;
  engine.def(
      "larynx_mesh",
      [](int order, const std::optional<RealArray>& sections, double major, double radius, double layer_thickness,
         std::optional<double> ligament_thickness, int layers_from_section, int layers_to_section,
         const std::string& layers_along, std::optional<int> around, double size, double growth, double tip_cut,
         std::optional<std::vector<int>> levels, int cover_rings, int ligament_rings, int body_rings) {
        Larynx larynx;
        if (sections) {
          larynx.shape.sections = to_sections(*sections);
        }
        larynx.shape.major = major;
        larynx.shape.radius = radius;
        larynx.shape.layer_thickness = layer_thickness;
        larynx.shape.ligament_thickness = ligament_thickness;
        larynx.shape.layers_from_section = layers_from_section;
        larynx.shape.layers_to_section = layers_to_section;
        larynx.shape.layers_along = to_layers_along(layers_along);
        if (levels) {
          larynx.meshed = Larynx::Levels{std::move(*levels), around.value_or(Larynx::Levels{}.around), cover_rings,
                                         ligament_rings, body_rings};
        } else {
          larynx.meshed =
              Larynx::Triangulated{size, growth, around.value_or(Larynx::Triangulated{}.around), tip_cut};
        }
        const Released released;
        return order == 2 ? quadratic_larynx_mesh(larynx) : larynx_mesh(larynx);
      },
      py::kw_only(), py::arg("order") = 1, py::arg("sections") = py::none(), py::arg("major") = shape.major,
      py::arg("radius") = shape.radius, py::arg("layer_thickness") = shape.layer_thickness,
      py::arg("ligament_thickness") = py::none(), py::arg("layers_from_section") = shape.layers_from_section,
      py::arg("layers_to_section") = shape.layers_to_section,
      py::arg("layers_along") = layers_along_name(shape.layers_along), py::arg("around") = py::none(),
      py::arg("size") = by_size.size, py::arg("growth") = by_size.growth, py::arg("tip_cut") = by_size.tip_cut,
      py::arg("levels") = py::none(), py::arg("cover_rings") = by_level.cover_rings,
      py::arg("ligament_rings") = by_level.ligament_rings, py::arg("body_rings") = by_level.body_rings);
  engine.def(
      "larynx_preset",
      [](const std::string& name) {
        const auto preset = presets.find(name);
        if (preset == presets.end()) {
          std::string known;
          for (const auto& [other, made] : presets) known += (known.empty() ? "" : ", ") + other;
          throw InvalidInput("larynx_preset: name = \"" + name + "\"; must be one of " + known + ".");
        }
        return larynx_fields(preset->second());
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
  engine.def("combine", &combine_meshes, py::arg("first"), py::arg("second"), py::arg("first_prefix") = "a.",
             py::arg("second_prefix") = "b.", py::call_guard<Released>());
}

}  // namespace

void bind_mesh(py::module_& engine) {
  bind_tet_mesh(engine);
  bind_larynx(engine);
  bind_block(engine);
}

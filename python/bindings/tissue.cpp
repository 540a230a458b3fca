#include "arrays.hpp"
#include "engine.hpp"
#include "options.hpp"
#include "plica/tissue/assembly.hpp"
#include "plica/tissue/strain.hpp"

using namespace plica;
using namespace plica::python;

namespace {

using Released = py::gil_scoped_release;

void bind_materials(py::module_& engine) {
  options<Isotropic>("Isotropic", option("E", &Isotropic::E), option("nu", &Isotropic::nu)).bind(engine);
  using Fibred = TransverselyIsotropic;
  options<Fibred>("TransverselyIsotropic", option("E", &Fibred::E), option("nu", &Fibred::nu),
                  option("E_fibre", &Fibred::E_fibre), option("nu_fibre", &Fibred::nu_fibre),
                  option("mu_fibre", &Fibred::mu_fibre), option("mu", &Fibred::mu),
                  option("fibre", &Fibred::fibre))
      .bind(engine);
  options<Material>(
      "Material", required("elasticity", &Material::elasticity), option("density", &Material::density),
      option("viscosity", &Material::viscosity), option("stiffening", &Material::stiffening),
      option("matrix_stiffening", &Material::matrix_stiffening), option("active_stress", &Material::active_stress))
      .bind(engine)
      .def("validate", &Material::validate, py::arg("where"));

  engine.def(
      "elasticity_matrix",
      [](const Material& valid) {
        valid.validate("elasticity_matrix");
        return give(Eigen::Matrix<double, 6, 6, Eigen::RowMajor>(elasticity_matrix(valid)));
      },
      py::arg("material"));
}

Tissue to_tissue(std::vector<Material> materials, std::vector<std::string> names, const py::array& cell_material) {
  return {std::move(materials), std::move(names), to_indices(cell_material, "Tissue", "cell_material")};
}

/// The assembler together with the mesh that it refers to and the tissue.
struct Assembly {
  std::shared_ptr<TetMesh> mesh;
  Tissue tissue;
  Assembler assembler;
};

template <typename Make>
Csr assemble(const Make& make) {
  SparseMatrix matrix;
  {
    const Released released;
    matrix = make().to_sparse();
  }
  return give_csr(std::move(matrix));
}

void bind_assembly(py::module_& engine) {
  py::class_<Assembly>(engine, "Assembly")
      .def(py::init([](const std::shared_ptr<TetMesh>& mesh, std::vector<Material> materials,
                       std::vector<std::string> material_names, const py::array& cell_material) {
             Tissue tissue = to_tissue(std::move(materials), std::move(material_names), cell_material);
             const Released released;
             tissue.validate(*mesh);
             return std::unique_ptr<Assembly>(new Assembly{mesh, std::move(tissue), Assembler(*mesh)});
           }),
           py::arg("mesh"), py::arg("materials"), py::arg("material_names"), py::arg("cell_material"))
      .def("mass", [](const Assembly& a) { return assemble([&] { return a.assembler.mass(a.tissue); }); })
      .def("stiffness",
           [](const Assembly& a) { return assemble([&] { return a.assembler.stiffness(a.tissue); }); })
      .def("viscosity",
           [](const Assembly& a) { return assemble([&] { return a.assembler.viscosity(a.tissue); }); })
      .def("stress",
           [](const Assembly& a) {
             return give([&] {
               const Released released;
               return a.assembler.stress(a.tissue);
             }());
           })
      .def("lumped_mass", [](const Assembly& a) { return give(a.assembler.lumped_mass(a.tissue)); });
}

/// The gauge together with the mesh that it refers to.
struct Gauge {
  std::shared_ptr<TetMesh> mesh;
  StrainGauge gauge;
};

void bind_strain(py::module_& engine) {
  py::class_<Gauge>(engine, "StrainGauge")
      .def(py::init([](const std::shared_ptr<TetMesh>& mesh, bool green) {
             const Released released;
             return std::unique_ptr<Gauge>(
                 new Gauge{mesh, StrainGauge(*mesh, green ? StrainMeasure::green : StrainMeasure::small)});
           }),
           py::arg("mesh"), py::kw_only(), py::arg("green") = false)
      .def(
          "at_points",
          [](const Gauge& g, const RealArray& displacement) {
            const Points u = to_points(displacement, "StrainGauge", "displacement");
            return give([&] {
              const Released released;
              return g.gauge.at_points(as_vector(u));
            }());
          },
          py::arg("displacement"))
      .def("volumes", [](const Gauge& g) { return give(g.gauge.volumes()); });
}

}  // namespace

void bind_tissue(py::module_& engine) {
  bind_materials(engine);
  bind_assembly(engine);
  bind_strain(engine);
}

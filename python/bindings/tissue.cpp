#include "arrays.hpp"
#include "engine.hpp"
#include "plica/tissue/assembly.hpp"

using namespace plica;
using namespace plica::python;

namespace {

using Released = py::gil_scoped_release;

void bind_materials(py::module_& engine) {
  const Isotropic isotropic;
  py::class_<Isotropic>(engine, "Isotropic")
      .def(py::init([](double E, double nu) {
             return Isotropic{E, nu};
           }),
           py::arg("E") = isotropic.E, py::arg("nu") = isotropic.nu)
      .def_readonly("E", &Isotropic::E)
      .def_readonly("nu", &Isotropic::nu);

  const TransverselyIsotropic fibred;
  const std::array<double, 3> along{fibred.fibre.x(), fibred.fibre.y(), fibred.fibre.z()};
  py::class_<TransverselyIsotropic>(engine, "TransverselyIsotropic")
      .def(py::init([](double E, double nu, double E_fibre, double nu_fibre, double mu_fibre,
                       std::optional<double> mu, const std::array<double, 3>& fibre) {
             return TransverselyIsotropic{
                 E, nu, E_fibre, nu_fibre, mu_fibre, mu, Vector3(fibre[0], fibre[1], fibre[2])};
           }),
           py::arg("E") = fibred.E, py::arg("nu") = fibred.nu, py::arg("E_fibre") = fibred.E_fibre,
           py::arg("nu_fibre") = fibred.nu_fibre, py::arg("mu_fibre") = fibred.mu_fibre, py::arg("mu") = fibred.mu,
           py::arg("fibre") = along)
      .def_readonly("E", &TransverselyIsotropic::E)
      .def_readonly("nu", &TransverselyIsotropic::nu)
      .def_readonly("E_fibre", &TransverselyIsotropic::E_fibre)
      .def_readonly("nu_fibre", &TransverselyIsotropic::nu_fibre)
      .def_readonly("mu_fibre", &TransverselyIsotropic::mu_fibre)
      .def_readonly("mu", &TransverselyIsotropic::mu)
      .def_property_readonly("fibre", [](const TransverselyIsotropic& law) {
        return std::make_tuple(law.fibre.x(), law.fibre.y(), law.fibre.z());
      });

  const Material material;
  py::class_<Material>(engine, "Material")
      .def(py::init(
               [](std::variant<Isotropic, TransverselyIsotropic> elasticity, double density, double viscosity) {
                 return Material{std::move(elasticity), density, viscosity};
               }),
           py::arg("elasticity"), py::arg("density") = material.density, py::arg("viscosity") = material.viscosity)
      .def_readonly("elasticity", &Material::elasticity)
      .def_readonly("density", &Material::density)
      .def_readonly("viscosity", &Material::viscosity)
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
      .def("lumped_mass", [](const Assembly& a) { return give(a.assembler.lumped_mass(a.tissue)); });
}

}  // namespace

void bind_tissue(py::module_& engine) {
  bind_materials(engine);
  bind_assembly(engine);
}

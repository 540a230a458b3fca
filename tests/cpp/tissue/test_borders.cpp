#include "../borders.hpp"
#include "plica/tissue/strain.hpp"
#include "scenes.hpp"

using namespace plica;
using borders::indices;
using borders::numbers;
using borders::refused;
using borders::sizes;

TEST_CASE("assembly refuses meshes, materials, marks and faces that do not fit") {
  TetMesh mesh = block_mesh({{0, 0, 0}, {1, 1, 1}, {2, 1, 1}});
  indices("Assembler::Assembler mesh.cells", mesh.cells, [&] { Assembler{mesh}; });
  indices("StrainGauge::StrainGauge mesh.cells", mesh.cells, [&] { StrainGauge{mesh}; });
  const Assembler assembler(mesh);
  Tissue tissue = scenes::uniform(mesh, scenes::oblique());
  const auto nodes = static_cast<std::size_t>(mesh.node_count());
  MassTransfer transfer{std::vector<char>(nodes), std::vector<char>(nodes), std::vector<char>(nodes)};
  transfer.massless.front() = 1;
  const auto redistribute = [&] { assembler.redistributed_mass(tissue, CellMass::lumped, transfer); };
  for (const auto& [name, call] :
       {std::pair<const char*, std::function<void()>>{"Assembler::mass tissue", [&] { assembler.mass(tissue); }},
        {"Assembler::lumped_mass tissue", [&] { assembler.lumped_mass(tissue); }},
        {"Assembler::redistributed_mass tissue", redistribute},
        {"Assembler::stiffness tissue", [&] { assembler.stiffness(tissue); }},
        {"Assembler::viscosity tissue", [&] { assembler.viscosity(tissue); }},
        {"Assembler::stretched tissue", [&] { assembler.stretched(tissue, mesh.points); }},
        {"Assembler::stress tissue", [&] { assembler.stress(tissue); }},
        {"Assembler::body_force tissue", [&] { assembler.body_force(tissue, Vector3::UnitX()); }},
        {"AffineStiffness::AffineStiffness tissue", [&] { AffineStiffness(assembler, tissue); }},
        {"Tissue::validate mesh", [&] { tissue.validate(mesh); }}}) {
    sizes(name, tissue.cell_material, call);
    indices(name, tissue.cell_material, call);
    sizes(name, tissue.names, call);
  }
  sizes("Assembler::redistributed_mass transfer.massless", transfer.massless, redistribute);
  sizes("Assembler::redistributed_mass transfer.held", transfer.held, redistribute);
  sizes("Assembler::redistributed_mass transfer.free", transfer.free, redistribute);
  Points x = mesh.points;
  sizes("Assembler::stretched x", x, [&] { assembler.stretched(tissue, x); });
  Faces faces = mesh.surface("x_max");
  indices("Assembler::traction faces", faces, [&] { assembler.traction(faces, Vector3::UnitX()); });
  for (const std::ptrdiff_t width : {0, 2, 6})
    refused("Assembler::traction faces", [&] { assembler.traction(Faces::Zero(1, width), Vector3::UnitX()); });
}

TEST_CASE("sums over coefficients, bases and strains refuse what is of other groups or meshes") {
  const TetMesh mesh = block_mesh({{0, 0, 0}, {1, 1, 1}, {2, 1, 1}});
  const Assembler assembler(mesh);
  const AffineStiffness affine(assembler, scenes::uniform(mesh, scenes::oblique()));
  Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor> coefficients(1, 6);
  coefficients << 1, 1, 1, 1, 1, 1;
  Vector viscosities = Vector::Ones(1);
  sizes("AffineStiffness::stiffness coefficients", coefficients, [&] { affine.stiffness(coefficients); });
  sizes("AffineStiffness::viscosity viscosities", viscosities, [&] { affine.viscosity(viscosities); });
  int coefficient = 0;
  numbers("stiffness_basis coefficient", coefficient, {-1, 6},
          [&] { stiffness_basis(coefficient, Vector3::UnitY()); });
  StrainGauge gauge(mesh);
  Vector displacement = 1e-3 * Vector::Random(3 * mesh.node_count());
  sizes("StrainGauge::measure displacement", displacement, [&] { gauge.measure(displacement); });
  sizes("StrainGauge::at_points displacement", displacement, [&] { gauge.at_points(displacement); });
}

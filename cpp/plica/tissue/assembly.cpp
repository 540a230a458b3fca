#include "plica/tissue/assembly.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/tissue/deformation.hpp"
#include "plica/tissue/stretch_law.hpp"

namespace plica {
namespace {

std::string count(std::ptrdiff_t n) { return std::to_string(n); }

Vector3 centre_of(const Points& x, const std::int32_t* cell) {
  Vector3 centre = Vector3::Zero();
  for (int a = 0; a < 4; ++a) centre += 0.25 * x.row(cell[a]).transpose();
  return centre;
}

void check_cells(const TetMesh& mesh) {
  const std::string where = "Assembler";
  const auto columns = mesh.cells.cols();
  if (columns != 4 && columns != 10) {
    throw InvalidInput(where, "columns of cells", static_cast<double>(columns), "", "4 or 10");
  }
  Element element(mesh.order());
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c) {
    for (std::ptrdiff_t a = 0; a < columns; ++a) {
      const std::int32_t node = mesh.cells(c, a);
      if (node < 0 || node >= mesh.node_count()) {
        throw InvalidInput(where, "cells[" + count(c) + ", " + count(a) + "]", node, "",
                           "in [0, " + count(mesh.node_count()) + ")");
      }
    }
    element.place(mesh.points, mesh.cells.row(c).data());
    const double jacobian = element.least_jacobian();
    if (!(jacobian > 0)) {
      const Vector3 centre = centre_of(mesh.points, mesh.cells.row(c).data());
      throw InvalidInput(where, "jacobian of cell " + count(c), jacobian, "m^3", "> 0",
                         "Its centre is at (" + number_text(centre.x()) + ", " + number_text(centre.y()) + ", " +
                             number_text(centre.z()) + ") m; it is inverted, flat or bent too far.");
    }
  }
}

// Cells of each node: those of node i are cell[start[i]] ... cell[start[i + 1] - 1], as cell * columns + a.
struct NodeCells {
  std::vector<std::int32_t> start, corner;

  explicit NodeCells(const TetMesh& mesh) {
    const auto* cells = mesh.cells.data();
    const auto size = static_cast<std::size_t>(mesh.cells.size());
    start.assign(static_cast<std::size_t>(mesh.node_count()) + 1, 0);
    for (std::size_t i = 0; i < size; ++i) ++start[static_cast<std::size_t>(cells[i]) + 1];
    for (std::size_t i = 1; i < start.size(); ++i) start[i] += start[i - 1];
    std::vector<std::int32_t> next(start.begin(), start.end() - 1);
    corner.resize(size);
    for (std::size_t i = 0; i < size; ++i) {
      corner[static_cast<std::size_t>(next[static_cast<std::size_t>(cells[i])]++)] = static_cast<std::int32_t>(i);
    }
  }
};

// Calls visit(cell, element) for every cell of the mesh with nodes there.
template <class Visit>
void for_each_cell(const TetMesh& mesh, const Points& points, Visit visit) {
  Element element(mesh.order());
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c) {
    element.place(points, mesh.cells.row(c).data());
    visit(c, element);
  }
}

BlockMatrix assemble_blocks(const TetMesh& mesh, const Pattern& pattern, const std::vector<std::int32_t>& scatter,
                            const Indices& cell_material, const std::vector<Matrix6>& D) {
  BlockMatrix K(pattern);
  std::vector<double> blocks(900);
  for_each_cell(mesh, mesh.points, [&](std::ptrdiff_t c, const Element& element) {
    const int n = element.nodes();
    element.stiffness(D[static_cast<std::size_t>(cell_material[c])], blocks.data());
    add_symmetric_blocks(blocks.data(), n, scatter.data() + c * n * n, K.values().data());
  });
  return K;
}

}  // namespace

void Tissue::validate(const TetMesh& mesh) const {
  const auto size = static_cast<double>(materials.size());
  if (materials.empty()) throw InvalidInput("Tissue", "number of materials", size, "", ">= 1");
  if (names.size() != materials.size()) {
    throw InvalidInput("Tissue", "number of names", static_cast<double>(names.size()), "",
                       number_text(size) + ", one a material");
  }
  for (std::size_t i = 0; i < materials.size(); ++i) materials[i].validate("tissue." + names[i]);
  if (cell_material.size() != mesh.cell_count()) {
    throw InvalidInput("Tissue", "size of cell_material", static_cast<double>(cell_material.size()), "",
                       count(mesh.cell_count()) + ", one a cell");
  }
  for (std::ptrdiff_t c = 0; c < cell_material.size(); ++c) {
    if (cell_material[c] >= 0 && cell_material[c] < static_cast<std::ptrdiff_t>(materials.size())) continue;
    std::string place = "Cell " + count(c);
    if (c < mesh.cell_layer.size()) {
      const auto layer = mesh.cell_layer[c];
      const bool named = layer >= 0 && layer < static_cast<std::ptrdiff_t>(mesh.layer_names.size());
      place +=
          " of layer " + (named ? '"' + mesh.layer_names[static_cast<std::size_t>(layer)] + '"' : count(layer));
    }
    throw InvalidInput("Tissue", "cell_material[" + count(c) + "]", cell_material[c], "",
                       "in [0, " + number_text(size) + ")", place + " has no material.");
  }
}

Assembler::Assembler(const TetMesh& mesh) : mesh_(mesh) {
  check_cells(mesh);
  const auto columns = static_cast<std::int32_t>(mesh.cells.cols());
  const auto nodes = static_cast<std::int32_t>(mesh.node_count());
  const NodeCells node_cells(mesh);
  auto pattern = std::make_shared<NodePattern>();
  pattern->row_start.reserve(static_cast<std::size_t>(nodes) + 1);
  pattern->row_start.push_back(0);
  pattern->column.reserve(static_cast<std::size_t>(nodes) * (columns == 4 ? 16 : 30));
  scatter_.resize(static_cast<std::size_t>(mesh.cells.size()) * static_cast<std::size_t>(columns));

  std::vector<std::int32_t> last_row(static_cast<std::size_t>(nodes), -1),
      position(static_cast<std::size_t>(nodes));
  std::vector<std::int32_t> row;
  for (std::int32_t i = 0; i < nodes; ++i) {
    const auto* corner = node_cells.corner.data();
    const auto begin = node_cells.start[static_cast<std::size_t>(i)];
    const auto end = node_cells.start[static_cast<std::size_t>(i) + 1];
    row.assign(1, i);
    last_row[static_cast<std::size_t>(i)] = i;
    for (auto k = begin; k < end; ++k) {
      const auto* cell = mesh.cells.row(corner[k] / columns).data();
      for (int b = 0; b < columns; ++b) {
        auto& seen = last_row[static_cast<std::size_t>(cell[b])];
        if (seen != i) row.push_back(cell[b]);
        seen = i;
      }
    }
    std::sort(row.begin(), row.end());
    for (const auto j : row) {
      position[static_cast<std::size_t>(j)] = static_cast<std::int32_t>(pattern->column.size());
      pattern->column.push_back(j);
    }
    pattern->row_start.push_back(static_cast<std::int32_t>(pattern->column.size()));
    for (auto k = begin; k < end; ++k) {
      const auto* cell = mesh.cells.row(corner[k] / columns).data();
      auto* entries = scatter_.data() + static_cast<std::ptrdiff_t>(corner[k]) * columns;
      for (int b = 0; b < columns; ++b) entries[b] = position[static_cast<std::size_t>(cell[b])];
    }
  }
  pattern->column.shrink_to_fit();
  pattern_ = std::move(pattern);
}

NodalMatrix Assembler::mass(const Tissue& tissue) const {
  tissue.validate(mesh_);
  NodalMatrix M(pattern_);
  double local[100];
  for_each_cell(mesh_, at_rest(mesh_), [&](std::ptrdiff_t c, const Element& element) {
    const int n = element.nodes();
    const double density = tissue.materials[static_cast<std::size_t>(tissue.cell_material[c])].density;
    const auto* entries = scatter_.data() + c * n * n;
    element.mass(local);
    for (int i = 0; i < n * n; ++i) M.values()[static_cast<std::size_t>(entries[i])] += density * local[i];
  });
  return M;
}

Vector Assembler::lumped_mass(const Tissue& tissue) const {
  tissue.validate(mesh_);
  Vector lumped = Vector::Zero(mesh_.node_count());
  double local[10];
  for_each_cell(mesh_, at_rest(mesh_), [&](std::ptrdiff_t c, const Element& element) {
    element.lumped_mass(tissue.materials[static_cast<std::size_t>(tissue.cell_material[c])].density, local);
    for (int a = 0; a < element.nodes(); ++a) lumped[mesh_.cells(c, a)] += local[a];
  });
  return lumped;
}

BlockMatrix Assembler::stiffness(const Tissue& tissue) const {
  if (mesh_.stretched()) return stretched(tissue, mesh_.points).slope;
  tissue.validate(mesh_);
  std::vector<Matrix6> D;
  for (const Material& material : tissue.materials) D.push_back(elasticity_matrix(material));
  return assemble_blocks(mesh_, pattern_, scatter_, tissue.cell_material, D);
}

Assembler::Stretched Assembler::stretched(const Tissue& tissue, const Points& x) const {
  tissue.validate(mesh_);
  require_size("Assembler", "x", x.rows(), mesh_.node_count());
  std::vector<StretchLaw> laws;
  for (const Material& material : tissue.materials) laws.emplace_back(material);
  Stretched found{Vector::Zero(x.size()), BlockMatrix(pattern_)};
  auto force = as_points(found.force);
  std::vector<double> blocks(900);
  std::array<Eigen::Matrix<double, 6, 3>, 10> B;
  for_each_cell(mesh_, at_rest(mesh_), [&](std::ptrdiff_t c, const Element& element) {
    const int n = element.nodes();
    const std::int32_t* cell = mesh_.cells.row(c).data();
    const StretchLaw& law = laws[static_cast<std::size_t>(tissue.cell_material[c])];
    std::fill(blocks.begin(), blocks.end(), 0.0);
    for (const auto& [at, share] : rule_of(mesh_)) {
      const Gradients gradients = element.gradients(at);
      const Matrix3 F = deformation(x, cell, gradients);
      if (!(F.determinant() > 0))
        throw CellInverted("cell " + count(c) + " at " + place_text(centre_of(x, cell)) + " turns inside out");
      const auto [T, slope] = law.at(F);
      const double volume = share * element.measure(at);
      const Matrix3 pull = volume * F * T;  // first Piola-Kirchhoff stress
      for (int a = 0; a < n; ++a) {
        B[static_cast<std::size_t>(a)] = strain_slope(F, gradients.row(a));
        force.row(cell[a]) += gradients.row(a) * pull.transpose();
      }
      for (int b = 0; b < n; ++b) {
        const Eigen::Matrix<double, 6, 3> answer = volume * slope * B[static_cast<std::size_t>(b)];
        const Vector3 turned = volume * T * gradients.row(b).transpose();
        for (int a = 0; a <= b; ++a) {
          Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(blocks.data() + 9 * (n * a + b));
          block += B[static_cast<std::size_t>(a)].transpose() * answer;
          block.diagonal().array() += gradients.row(a).dot(turned);
        }
      }
    }
    add_symmetric_blocks(blocks.data(), n, scatter_.data() + c * n * n, found.slope.values().data());
  });
  return found;
}

Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor> Assembler::stress(const Tissue& tissue) const {
  tissue.validate(mesh_);
  std::vector<StretchLaw> laws;
  for (const Material& material : tissue.materials) laws.emplace_back(material);
  Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor> stress(mesh_.cell_count(), 6);
  for_each_cell(mesh_, at_rest(mesh_), [&](std::ptrdiff_t c, const Element& element) {
    const Matrix3 F = deformation(mesh_.points, mesh_.cells.row(c).data(), element.centroid_gradients());
    const Matrix3 T = laws[static_cast<std::size_t>(tissue.cell_material[c])].at(F).stress;
    const Matrix3 cauchy = F * T * F.transpose() / F.determinant();
    stress.row(c) << cauchy(0, 0), cauchy(1, 1), cauchy(2, 2), cauchy(0, 1), cauchy(1, 2), cauchy(2, 0);
  });
  return stress;
}

BlockMatrix Assembler::viscosity(const Tissue& tissue) const {
  tissue.validate(mesh_);
  std::vector<Matrix6> D;
  for (const Material& material : tissue.materials) D.push_back(viscosity_matrix(material));
  return assemble_blocks(mesh_, pattern_, scatter_, tissue.cell_material, D);
}

Vector Assembler::body_force(const Tissue& tissue, const Vector3& acceleration) const {
  tissue.validate(mesh_);
  Vector force = Vector::Zero(3 * mesh_.node_count());
  auto nodal = as_points(force);
  double local[10];
  for_each_cell(mesh_, at_rest(mesh_), [&](std::ptrdiff_t c, const Element& element) {
    const double density = tissue.materials[static_cast<std::size_t>(tissue.cell_material[c])].density;
    element.load(local);
    for (int a = 0; a < element.nodes(); ++a) {
      nodal.row(mesh_.cells(c, a)) += density * local[a] * acceleration.transpose();
    }
  });
  return force;
}

Vector Assembler::traction(const Faces& faces, const Vector3& traction) const {
  const int columns = mesh_.order() == 2 ? 6 : 3;
  if (faces.rows() > 0 && faces.cols() != columns) {
    throw InvalidInput("traction", "columns of faces", static_cast<double>(faces.cols()), "",
                       count(columns) + " on this mesh");
  }
  Vector force = Vector::Zero(3 * mesh_.node_count());
  auto nodal = as_points(force);
  for (std::ptrdiff_t f = 0; f < faces.rows(); ++f) {
    Eigen::Matrix<double, 6, 3> x = Eigen::Matrix<double, 6, 3>::Zero();
    for (int a = 0; a < columns; ++a) {
      const auto node = faces(f, a);
      if (node < 0 || node >= mesh_.node_count()) {
        throw InvalidInput("traction", "faces[" + count(f) + ", " + count(a) + "]", node, "",
                           "in [0, " + count(mesh_.node_count()) + ")");
      }
      x.row(a) = mesh_.points.row(node);
    }
    Eigen::Matrix<double, 6, 1> share = Eigen::Matrix<double, 6, 1>::Zero();  // int N_a dA, m^2
    if (columns == 3) {
      const Vector3 first = x.row(1) - x.row(0), second = x.row(2) - x.row(0);
      share.head<3>().setConstant(first.cross(second).norm() / 6);
    } else {
      for (const auto& point : triangle_rule_degree_5()) {
        const Eigen::Matrix<double, 3, 3> along = x.transpose() * triangle_slopes(point.at);
        const Vector3 first = along.col(1) - along.col(0), second = along.col(2) - along.col(0);
        share += 0.5 * first.cross(second).norm() * point.weight * triangle_shapes(point.at);
      }
    }
    for (int a = 0; a < columns; ++a) nodal.row(faces(f, a)) += share[a] * traction.transpose();
  }
  return force;
}

}  // namespace plica

#include <algorithm>

#include "plica/core/error.hpp"
#include "plica/tissue/assembly.hpp"
#include "plica/tissue/element.hpp"

namespace plica {
namespace {

void check_rows(const char* name, std::ptrdiff_t rows, std::size_t groups) {
  if (rows == static_cast<std::ptrdiff_t>(groups)) return;
  throw InvalidInput("AffineStiffness", std::string("rows of ") + name, static_cast<double>(rows), "",
                     std::to_string(groups) + ", one a group");
}

// values[9 * entries[i] ...] += factor * part[9 i ...]
void add_scaled(const std::vector<std::int32_t>& entries, const std::vector<double>& part, double factor,
                std::vector<double>& values) {
  for (std::size_t i = 0; i < entries.size(); ++i) {
    double* target = values.data() + 9 * static_cast<std::ptrdiff_t>(entries[i]);
    const double* source = part.data() + 9 * i;
    for (int j = 0; j < 9; ++j) target[j] += factor * source[j];
  }
}

}  // namespace

AffineStiffness::AffineStiffness(const Assembler& assembler, const Tissue& tissue) : pattern_(assembler.pattern_) {
  const TetMesh& mesh = assembler.mesh_;
  tissue.validate(mesh);
  if (mesh.stretched())
    throw InvalidInput(
        "AffineStiffness: tissue is stretched; must be at rest: its stress depends on the "
        "coefficients, too.");
  groups_.resize(tissue.materials.size());
  std::vector<std::vector<std::int32_t>> cells(groups_.size());
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c) {
    cells[static_cast<std::size_t>(tissue.cell_material[c])].push_back(static_cast<std::int32_t>(c));
  }
  Element element(mesh.order());
  const int pairs = element.nodes() * element.nodes();
  std::vector<std::int32_t> place(static_cast<std::size_t>(pattern_->entries()), -1);  // in the group's entries
  std::vector<std::int32_t> targets(static_cast<std::size_t>(pairs));
  std::vector<double> blocks(static_cast<std::size_t>(9 * pairs));
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    Group& group = groups_[g];
    for (const auto c : cells[g]) {
      const auto* entries = assembler.scatter_.data() + static_cast<std::ptrdiff_t>(c) * pairs;
      for (int i = 0; i < pairs; ++i) {
        auto& seen = place[static_cast<std::size_t>(entries[i])];
        if (seen < 0) group.entries.push_back(entries[i]);
        seen = 0;
      }
    }
    std::sort(group.entries.begin(), group.entries.end());
    for (std::size_t i = 0; i < group.entries.size(); ++i) {
      place[static_cast<std::size_t>(group.entries[i])] = static_cast<std::int32_t>(i);
    }
    std::array<Matrix6, 6> basis;
    for (int k = 0; k < 6; ++k) {
      basis[static_cast<std::size_t>(k)] = stiffness_basis(k, fibre_of(tissue.materials[g]));
      group.stiffness[static_cast<std::size_t>(k)].assign(9 * group.entries.size(), 0.0);
    }
    group.viscosity.assign(9 * group.entries.size(), 0.0);
    Material unit;
    unit.viscosity = 1;
    const Matrix6 unit_viscosity = viscosity_matrix(unit);
    for (const auto c : cells[g]) {
      element.place(mesh.points, mesh.cells.row(c).data());
      const auto* entries = assembler.scatter_.data() + static_cast<std::ptrdiff_t>(c) * pairs;
      for (int i = 0; i < pairs; ++i)
        targets[static_cast<std::size_t>(i)] = place[static_cast<std::size_t>(entries[i])];
      for (std::size_t k = 0; k < 6; ++k) {
        element.stiffness(basis[k], blocks.data());
        add_symmetric_blocks(blocks.data(), element.nodes(), targets.data(), group.stiffness[k].data());
      }
      element.stiffness(unit_viscosity, blocks.data());
      add_symmetric_blocks(blocks.data(), element.nodes(), targets.data(), group.viscosity.data());
    }
    for (const auto entry : group.entries) place[static_cast<std::size_t>(entry)] = -1;
  }
}

BlockMatrix AffineStiffness::stiffness(
    const Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>& coefficients) const {
  check_rows("coefficients", coefficients.rows(), groups_.size());
  BlockMatrix K(pattern_);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    for (std::size_t k = 0; k < 6; ++k) {
      add_scaled(groups_[g].entries, groups_[g].stiffness[k],
                 coefficients(static_cast<std::ptrdiff_t>(g), static_cast<std::ptrdiff_t>(k)), K.values());
    }
  }
  return K;
}

BlockMatrix AffineStiffness::viscosity(const Vector& viscosities) const {
  check_rows("viscosities", viscosities.size(), groups_.size());
  BlockMatrix C(pattern_);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    add_scaled(groups_[g].entries, groups_[g].viscosity, viscosities[static_cast<std::ptrdiff_t>(g)], C.values());
  }
  return C;
}

}  // namespace plica

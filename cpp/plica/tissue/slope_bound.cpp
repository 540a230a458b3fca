#include "plica/tissue/slope_bound.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <limits>

#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"
#include "plica/tissue/deformation.hpp"

namespace plica {
namespace {

constexpr std::ptrdiff_t cells_a_chunk = 64;

/// H . B H of H = dy/dX, H_iJ at 3 J + i.
using Form = Eigen::Matrix<double, 9, 9>;

/// e (slope of P on F) + c (slope of P_v on dF/dt) where the deformation is F, J = det F > 0.
Form form_at(const Matrix3& F, double J, const StretchLaw& law, double elastic, double viscous) {
  const auto [T, slope] = law.at(F);
  const Matrix3 back = F.inverse();
  Eigen::Matrix<double, 6, 9> strain, rate;  // of H: engineering strain's change, and twice d's shears
  for (int k = 0; k < 3; ++k) {
    strain.middleCols<3>(3 * k) = strain_slope(F, Vector3::Unit(k));
    rate.middleCols<3>(3 * k) = strain_slope(Matrix3::Identity(), back.row(k));
  }
  Form form = elastic * (strain.transpose() * slope * strain);
  for (int k = 0; k < 3; ++k)
    for (int l = 0; l < 3; ++l) form.block<3, 3>(3 * k, 3 * l).diagonal().array() += elastic * T(k, l);
  if (viscous > 0) {
    Vector6 weight = Vector6::Constant(viscous * J);
    weight.tail<3>() *= 0.5;  // d : d has each shear twice
    form += rate.transpose() * weight.asDiagonal() * rate;
  }
  return form;
}

/// Of the largest eigenvalue, >= 0.
double above_eigenvalue(const Form& form) {
  double discs = 0.0;
  for (int k = 0; k < 9; ++k)
    discs = std::max(discs, form.col(k).cwiseAbs().sum() - std::abs(form(k, k)) + form(k, k));
  return std::min(discs, form.norm());
}

double laplacian_by_mass(const Element& element, const TetrahedronRule& rule, double density) {
  const int n = element.nodes();
  Eigen::MatrixXd laplacian = Eigen::MatrixXd::Zero(n, n);
  for (const auto& [at, share] : rule) {
    const Gradients gradients = element.gradients(at);
    laplacian += share * element.measure(at) * gradients * gradients.transpose();
  }
  Vector mass(n);
  element.lumped_mass(density, mass.data());
  const Vector scale = mass.cwiseInverse().cwiseSqrt();
  laplacian = (scale.asDiagonal() * laplacian * scale.asDiagonal()).eval();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(laplacian, Eigen::EigenvaluesOnly).eigenvalues()[n - 1];
}

}  // namespace

SlopeBound::SlopeBound(const TetMesh& mesh, const Tissue& tissue)
    : mesh_(mesh), tissue_(tissue), by_mass_(mesh.cell_count()) {
  tissue.validate(mesh);
  for (const Material& material : tissue.materials) laws_.emplace_back(material);
  Element element(mesh.order());
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c) {
    element.place(at_rest(mesh), mesh.cells.row(c).data());
    const auto m = static_cast<std::size_t>(tissue.cell_material[c]);
    by_mass_[c] = laplacian_by_mass(element, rule_of(mesh), tissue.materials[m].density);
  }
}

SlopeBound::Largest SlopeBound::largest(const Vector& u, const Vector* known, double elastic,
                                        double viscous) const {
  require_size("SlopeBound", "u", u.size(), 3 * mesh_.node_count());
  const Points x = mesh_.points + as_points(u);
  const Points before = known ? Points(mesh_.points + as_points(*known)) : Points();
  const TetrahedronRule& rule = rule_of(mesh_);
  Vector of_cell(mesh_.cell_count());
  for_chunks(mesh_.cell_count(), cells_a_chunk, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    Element element(mesh_.order());
    for (std::ptrdiff_t c = begin; c < end; ++c) {
      const std::int32_t* cell = mesh_.cells.row(c).data();
      const auto m = static_cast<std::size_t>(tissue_.cell_material[c]);
      const double of_rate = viscous * tissue_.materials[m].viscosity;
      element.place(at_rest(mesh_), cell);
      double worst = 0.0;
      for (const auto& [at, share] : rule) {
        const Gradients gradients = element.gradients(at);
        const auto form_of = [&](const Points& places, Form& form) {
          const Matrix3 F = deformation(places, cell, gradients);
          const double J = F.determinant();
          if (J > 0) form = form_at(F, J, laws_[m], elastic, of_rate);
          return J > 0;
        };
        Form form, less;
        if (!form_of(x, form) || (known && !form_of(before, less))) {
          worst = std::numeric_limits<double>::infinity();
          break;
        }
        if (known) form -= less;
        worst = std::max(worst, above_eigenvalue(form));
      }
      of_cell[c] = by_mass_[c] * worst;
    }
  });
  Largest found;
  for (std::int32_t c = 0; c < of_cell.size(); ++c)
    if (of_cell[c] > found.value) found = {of_cell[c], c};
  return found;
}

}  // namespace plica

#include "plica/tissue/material.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"

namespace plica {
namespace {

void require_finite(const std::string& where, const char* name, double value, const char* unit) {
  if (!std::isfinite(value)) throw InvalidInput(where, name, value, unit, "finite");
}

void require_positive(const std::string& where, const char* name, double value, const char* unit) {
  require_finite(where, name, value, unit);
  if (!(value > 0)) throw InvalidInput(where, name, value, unit, "> 0", "Is the unit right?");
}

void validate_elasticity(const Isotropic& law, const std::string& where) {
  require_positive(where, "E", law.E, "Pa");
  require_finite(where, "nu", law.nu, "");
  if (!(law.nu > -1)) throw InvalidInput(where, "nu", law.nu, "", "> -1");
  if (!(law.nu < 0.5)) {
    throw InvalidInput(where, "nu", law.nu, "", "< 0.5",
                       "Only transversely isotropic tissue may have a larger one.");
  }
}

void validate_elasticity(const TransverselyIsotropic& law, const std::string& where) {
  require_positive(where, "E", law.E, "Pa");
  require_positive(where, "E_fibre", law.E_fibre, "Pa");
  require_positive(where, "mu_fibre", law.mu_fibre, "Pa");
  if (law.mu) require_positive(where, "mu", *law.mu, "Pa");
  require_finite(where, "nu", law.nu, "");
  require_finite(where, "nu_fibre", law.nu_fibre, "");
  if (!(law.nu > -1)) throw InvalidInput(where, "nu", law.nu, "", "> -1");
  if (!(law.nu < 1)) throw InvalidInput(where, "nu", law.nu, "", "< 1");
  const std::string bound = " (k = E'(1 - nu) - 2 nu'^2 E > 0)";
  if (!(law.E_fibre * (1 - law.nu) - 2 * law.nu_fibre * law.nu_fibre * law.E > 0)) {
    const double largest = 1 - 2 * law.nu_fibre * law.nu_fibre * law.E / law.E_fibre;
    if (largest > -1) {
      throw InvalidInput(where, "nu", law.nu, "", "< " + number_text(largest) + bound,
                         "Lower nu or nu_fibre, or raise E_fibre.");
    }
    const double widest = std::sqrt(law.E_fibre * (1 - law.nu) / (2 * law.E));
    throw InvalidInput(where, "nu_fibre", law.nu_fibre, "",
                       "between -" + number_text(widest) + " and " + number_text(widest) + bound,
                       "No nu goes with it; lower nu_fibre, or raise E_fibre.");
  }
  for (int i = 0; i < 3; ++i) require_finite(where, "fibre", law.fibre[i], "");
  if (!(law.fibre.norm() > 0)) throw InvalidInput(where, "length of fibre", 0, "", "> 0");
}

Vector6 coefficients_of(const Isotropic& law) {
  const double mu = law.E / (2 * (1 + law.nu));
  const double lambda = law.E * law.nu / ((1 + law.nu) * (1 - 2 * law.nu));
  Vector6 c;
  c << lambda + 2 * mu, lambda, lambda, lambda + 2 * mu, mu, mu;
  return c;
}

Vector6 coefficients_of(const TransverselyIsotropic& law) {
  const double k = law.E_fibre * (1 - law.nu) - 2 * law.nu_fibre * law.nu_fibre * law.E;
  const double across = law.E / ((1 + law.nu) * k);
  const double square = law.nu_fibre * law.nu_fibre * law.E;
  Vector6 c;
  c << (law.E_fibre - square) * across, (square + law.nu * law.E_fibre) * across,
      law.E * law.E_fibre * law.nu_fibre / k, law.E_fibre * law.E_fibre * (1 - law.nu) / k, law.mu_fibre,
      law.mu.value_or(law.E / (2 * (1 + law.nu)));
  return c;
}

// Basis with the fibre along y, as Paper A, Eq. (6) has it.
Matrix6 basis_along_y(int coefficient) {
  Matrix6 S = Matrix6::Zero();
  switch (coefficient) {
    case 0:
      S(0, 0) = S(2, 2) = 1;
      break;
    case 1:
      S(0, 2) = S(2, 0) = 1;
      break;
    case 2:
      S(0, 1) = S(1, 0) = S(1, 2) = S(2, 1) = 1;
      break;
    case 3:
      S(1, 1) = 1;
      break;
    case 4:
      S(3, 3) = S(4, 4) = 1;
      break;
    default:
      S(5, 5) = 1;
      break;
  }
  return S;
}

// The smallest rotation of the y axis into the unit vector a, a.y >= 0: I + [v] + [v]^2 / (1 + a.y), v = y x a.
Matrix3 rotation_of_y_to(const Vector3& a) {
  const Vector3 v = Vector3::UnitY().cross(a);
  Matrix3 V;
  V << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return Matrix3::Identity() + V + V * V / (1 + a.y());
}

// (6, 6) turning global engineering strains into those along the columns of R.
Matrix6 strain_rotation(const Matrix3& R) {
  constexpr int pair[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  Matrix6 T;
  for (int c = 0; c < 6; ++c) {
    Matrix3 strain = Matrix3::Zero();
    strain(pair[c][0], pair[c][1]) += 0.5;
    strain(pair[c][1], pair[c][0]) += 0.5;
    const Matrix3 turned = R.transpose() * strain * R;
    for (int r = 0; r < 6; ++r) T(r, c) = (r < 3 ? 1 : 2) * turned(pair[r][0], pair[r][1]);
  }
  return T;
}

}  // namespace

void Material::validate(const std::string& where) const {
  std::visit([&](const auto& law) { validate_elasticity(law, where); }, elasticity);
  require_positive(where, "density", density, "kg/m^3");
  require_finite(where, "viscosity", viscosity, "Pa s");
  if (!(viscosity >= 0)) throw InvalidInput(where, "viscosity", viscosity, "Pa s", ">= 0");
  require_finite(where, "stiffening", stiffening, "");
  if (!(stiffening >= 0)) throw InvalidInput(where, "stiffening", stiffening, "", ">= 0");
  if (stiffening > 0 && !std::holds_alternative<TransverselyIsotropic>(elasticity))
    throw InvalidInput(where, "stiffening", stiffening, "", "0 in isotropic tissue",
                       "Its fibres are what stiffens. Use matrix_stiffening.");
  require_finite(where, "matrix_stiffening", matrix_stiffening, "");
  if (!(matrix_stiffening >= 0)) throw InvalidInput(where, "matrix_stiffening", matrix_stiffening, "", ">= 0");
  require_finite(where, "active_stress", active_stress, "Pa");
}

Vector6 stiffness_coefficients(const Material& material) {
  return std::visit([](const auto& law) { return coefficients_of(law); }, material.elasticity);
}

Matrix6 stiffness_basis(int coefficient, const Vector3& fibre) {
  require_index("stiffness_basis", "coefficient", coefficient, 6);
  const Matrix6 S = basis_along_y(coefficient);
  const Matrix6 T = strain_rotation(rotation_of_y_to(fibre.normalized() * (fibre.y() < 0 ? -1 : 1)));
  const Matrix6 turned = T.transpose() * S * T;
  return 0.5 * (turned + turned.transpose());
}

Vector3 fibre_of(const Material& material) {
  const auto* law = std::get_if<TransverselyIsotropic>(&material.elasticity);
  return law ? law->fibre : Vector3::UnitY();
}

Matrix6 elasticity_matrix(const Material& material) {
  const Vector6 c = stiffness_coefficients(material);
  const Vector3 fibre = fibre_of(material);
  Matrix6 S = Matrix6::Zero();
  for (int i = 0; i < 6; ++i) S += c[i] * stiffness_basis(i, fibre);
  return S;
}

Matrix6 viscosity_matrix(const Material& material) {
  Vector6 diagonal;
  diagonal << 1, 1, 1, 0.5, 0.5, 0.5;
  return (material.viscosity * diagonal).asDiagonal();
}

}  // namespace plica

#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>

#include "plica/core/types.hpp"

namespace plica {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Isotropic linear elasticity.
struct Isotropic {
  double E = 20e3;   // Pa, > 0
  double nu = 0.45;  // -, in (-1, 1/2)
};

/// Transversely isotropic linear elasticity, Paper A, Eq. (6), about a fibre direction.
/// nu may exceed 1/2: the bound is k = E'(1 - nu) - 2 nu'^2 E > 0.
struct TransverselyIsotropic {
  double E = 1e3;          // Pa, > 0, across the fibre
  double nu = 0.66;        // -, in (-1, 1), across the fibre
  double E_fibre = 10e3;   // Pa, > 0, along the fibre (E')
  double nu_fibre = 0.66;  // - (nu')
  double mu_fibre = 10e3;  // Pa, > 0 (mu')
  /// Pa, > 0; shear modulus across the fibre. Without a value: E / (2 (1 + nu)), the isotropy of the
  /// plane demands it; the thesis prints E / (1 + nu) (Eq. 2.19), which is not isotropic in the plane.
  std::optional<double> mu;
  Vector3 fibre = Vector3::UnitY();  // any length > 0
};

/// Kelvin-Voigt tissue: sigma = S eps + eta d(eps)/dt with eps the strain *tensor* (Paper A, Eq. 7).
struct Material {
  std::variant<Isotropic, TransverselyIsotropic> elasticity = Isotropic{};
  double density = 1020.0;  // kg/m^3, > 0
  double viscosity = 0.0;   // Pa s, >= 0
  /// -, >= 0, of tissue with fibres alone: what E_fibre bears along them rises by exp(stiffening (lambda^2 -
  /// 1)^2), lambda their stretch (StretchLaw). Small strains do not know it.
  double stiffening = 0.0;
  /// -, >= 0: the matrix between the fibres bears 1 + matrix_stiffening (tr E - ln J) times as much, E the
  /// Green-Lagrange strain and J the volume (StretchLaw). Small strains do not know it.
  double matrix_stiffening = 0.0;
  double active_stress = 0.0;  // Pa, of stretched tissue: pulls along the fibre, by area at rest

  /// Throws InvalidInput that starts with `where` and names the violated bound.
  void validate(const std::string& where) const;
};

/// The six numbers in which S is linear: S = sum_c coefficients[c] * basis_c(fibre);
/// order: S11, S13 (both across), S12 (across-along), S22 (along), mu' , mu. Pa.
Vector6 stiffness_coefficients(const Material& material);
/// (6, 6) Voigt order xx yy zz xy yz zx on engineering strain, in the global frame. The axes of Eq. (6)
/// (fibre along y) are turned by the smallest rotation that brings y onto the line of the fibre; this
/// choice matters only when mu differs from E / (2 (1 + nu)).
Matrix6 stiffness_basis(int coefficient, const Vector3& fibre);
/// The y axis for isotropic tissue, which has none of its own.
Vector3 fibre_of(const Material& material);
/// S, (6, 6) Pa.
Matrix6 elasticity_matrix(const Material& material);
/// eta diag(1, 1, 1, 1/2, 1/2, 1/2), Pa s.
Matrix6 viscosity_matrix(const Material& material);

}  // namespace plica

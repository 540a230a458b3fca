#pragma once
#include "plica/tissue/material.hpp"

namespace plica {

/// Stress of stretched tissue (docs/theory/posture.md): that of a neo-Hookean solid that compresses, with fibres.
/// With C = F^T F, E = (C - I) / 2, J = det F, the fibre a (unit) and q = a . E a, the energy is
///   W = mu (w + m w^2 / 2) + lambda (ln J)^2 / 2 + 2 beta q ln J + 2 (mu' - mu) (|E a|^2 - q^2) + e q^2 / 2
///     + E' ((exp(4 k q^2) - 1) / (8 k) - q^2 / 2) where q > 0 + s (sqrt(1 + 2 q) - 1),
/// w = tr E - ln J >= 0; lambda, beta and e such that small strains have the stiffness of the
/// material; k Material::stiffening, m Material::matrix_stiffening, s Material::active_stress.
class StretchLaw {
 public:
  /// Throws InvalidInput for tissue that is not isotropic across its fibre.
  explicit StretchLaw(const Material& material);

  struct Response {
    Matrix3 stress;  // dW/dE, second Piola-Kirchhoff, Pa
    Matrix6 slope;   // of it on engineering strain, Pa, Voigt order xx yy zz xy yz zx
  };
  /// det F > 0.
  Response at(const Matrix3& F) const;
  /// W, J/m^3 at rest.
  double energy(const Matrix3& F) const;
  /// What W is made of, for kernels: Pa but for k and m; shear = mu' - mu, along = e, fibre_modulus = E'.
  struct Moduli {
    double mu, lambda, beta, shear, along, fibre_modulus, stiffening, matrix_stiffening, active;
    Vector3 fibre;  // unit
  };
  Moduli moduli() const {
    return {mu_, lambda_, beta_, shear_, along_, fibre_modulus_, stiffening_, matrix_stiffening_, active_, fibre_};
  }

 private:
  double mu_, lambda_, beta_, shear_, along_;  // Pa: shear_ = mu' - mu, along_ = e
  double fibre_modulus_ = 0.0;                 // Pa, E'
  double stiffening_, matrix_stiffening_;      // -
  double active_;                              // Pa
  Vector3 fibre_;                              // unit
  Vector6 dyad_;                               // a a
  Matrix6 constant_;                           // of the slope: what does not depend on F, Pa
};

}  // namespace plica

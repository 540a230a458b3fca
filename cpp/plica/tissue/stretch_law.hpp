#pragma once
#include "plica/tissue/material.hpp"

namespace plica {

/// Stress of stretched tissue (docs/theory/posture.md). With Green and Lagrange's strain E = (F^T F - I) / 2, the
/// fibre a (unit), q = <a . E a> its part in tension, I4 = 1 + 2 a . E a and S the matrix of small strains, the
/// second Piola-Kirchhoff stress is
///   T = S : E + E' q (exp(4 k q^2) - 1) a a + s / sqrt(I4) a a,
/// k Material::stiffening and s Material::active_stress: at F = I and without s the stress and its slope are those
/// of linear tissue. T is a gradient, so that its slope is symmetric.
class StretchLaw {
 public:
  explicit StretchLaw(const Material& material);

  struct Response {
    Matrix3 stress;  // T, Pa
    Matrix6 slope;   // dT/dE on engineering strain, Pa, Voigt order xx yy zz xy yz zx
  };
  Response at(const Matrix3& F) const;
  /// J/m^3 at rest, whose gradient T is.
  double energy(const Matrix3& F) const;

 private:
  Matrix6 elasticity_;
  Vector6 dyad_;        // a a on stresses
  Vector3 fibre_;       // unit
  double along_ = 0.0;  // E', Pa
  double stiffening_;
  double active_;  // Pa
};

}  // namespace plica

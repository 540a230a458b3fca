#include "plica/tissue/stretch_law.hpp"

#include <Eigen/LU>
#include <cmath>

#include "plica/core/error.hpp"

namespace plica {
namespace {

constexpr int pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};

Vector6 voigt(const Matrix3& A) {
  Vector6 v;
  for (int i = 0; i < 6; ++i) v[i] = A(pairs[i][0], pairs[i][1]);
  return v;
}

/// (A_ik B_jl + A_il B_jk) / 2 + the same with A and B exchanged, halved.
Matrix6 products(const Matrix3& A, const Matrix3& B) {
  Matrix6 D;
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 6; ++c) {
      const auto [i, j] = pairs[r];
      const auto [k, l] = pairs[c];
      D(r, c) = 0.25 * (A(i, k) * B(j, l) + A(i, l) * B(j, k) + B(i, k) * A(j, l) + B(i, l) * A(j, k));
    }
  return D;
}

}  // namespace

StretchLaw::StretchLaw(const Material& material)
    : stiffening_(material.stiffening),
      matrix_stiffening_(material.matrix_stiffening),
      active_(material.active_stress),
      fibre_(fibre_of(material).normalized()),
      dyad_(voigt(fibre_ * fibre_.transpose())) {
  const Vector6 S = stiffness_coefficients(material);  // 11, 13 (across), 12, 22 (along), mu', mu
  mu_ = S[5];
  lambda_ = S[1];
  beta_ = 0.5 * (S[2] - S[1]);
  shear_ = S[4] - S[5];
  along_ = S[3] - 2 * S[2] + S[1] - 2 * S[5];
  if (!(std::abs(S[0] - S[1] - 2 * mu_) <= 1e-9 * S[0]))
    throw InvalidInput("Stretched tissue", "mu", mu_, "Pa",
                       number_text(0.5 * (S[0] - S[1])) + ", E / (2 (1 + nu))",
                       "It must be isotropic across its fibre.");
  if (const auto* law = std::get_if<TransverselyIsotropic>(&material.elasticity)) fibre_modulus_ = law->E_fibre;
  const Matrix3 one = Matrix3::Identity(), dyad = fibre_ * fibre_.transpose();
  constant_ = 4 * shear_ * products(one, dyad) + (along_ - 4 * shear_) * (dyad_ * dyad_.transpose());
}

StretchLaw::Response StretchLaw::at(const Matrix3& F) const {
  const Matrix3 C = F.transpose() * F, inverse = C.inverse();
  const Matrix3 E = 0.5 * (C - Matrix3::Identity());
  const Vector3 pulled = E * fibre_;
  const double q = fibre_.dot(pulled), volume = std::log(F.determinant());
  double tension = 2 * beta_ * volume + (along_ - 4 * shear_) * q, stiffness = 0.0;
  if (stiffening_ > 0 && q > 0) {
    const double square = 4 * stiffening_ * q * q, more = std::expm1(square);
    tension += fibre_modulus_ * q * more;
    stiffness += fibre_modulus_ * (more + 2 * square * (more + 1));
  }
  if (active_ != 0) {
    const double stretch = std::sqrt(1 + 2 * q);
    tension += active_ / stretch;
    stiffness -= active_ / (stretch * stretch * stretch);
  }
  const double mu = mu_ * (1 + matrix_stiffening_ * (E.trace() - volume));
  const double pressure = lambda_ * volume + 2 * beta_ * q - mu;
  Response response;
  response.stress = mu * Matrix3::Identity() + pressure * inverse + tension * fibre_ * fibre_.transpose() +
                    2 * shear_ * (pulled * fibre_.transpose() + fibre_ * pulled.transpose());
  const Vector6 c = voigt(inverse);
  response.slope = constant_ - 2 * pressure * products(inverse, inverse) + lambda_ * (c * c.transpose()) +
                   2 * beta_ * (c * dyad_.transpose() + dyad_ * c.transpose()) +
                   stiffness * (dyad_ * dyad_.transpose());
  if (matrix_stiffening_ > 0) {
    const Vector6 shape_slope = voigt(Matrix3::Identity()) - c;  // dw/dE
    response.slope += matrix_stiffening_ * mu_ * (shape_slope * shape_slope.transpose());
  }
  return response;
}

double StretchLaw::energy(const Matrix3& F) const {
  const Matrix3 E = 0.5 * (F.transpose() * F - Matrix3::Identity());
  const Vector3 pulled = E * fibre_;
  const double q = fibre_.dot(pulled), volume = std::log(F.determinant());
  const double shape = E.trace() - volume;
  double energy = mu_ * shape * (1 + 0.5 * matrix_stiffening_ * shape) + 0.5 * lambda_ * volume * volume +
                  2 * beta_ * q * volume + 2 * shear_ * (pulled.squaredNorm() - q * q) + 0.5 * along_ * q * q;
  if (stiffening_ > 0 && q > 0)
    energy += fibre_modulus_ * (std::expm1(4 * stiffening_ * q * q) / (8 * stiffening_) - 0.5 * q * q);
  if (active_ != 0) energy += active_ * (std::sqrt(1 + 2 * q) - 1);
  return energy;
}

}  // namespace plica

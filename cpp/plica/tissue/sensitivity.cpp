#include "plica/tissue/sensitivity.hpp"

#include "plica/core/error.hpp"

namespace plica {
namespace {

std::vector<std::string> parameters_of(const Isotropic&) { return {"E", "nu"}; }

std::vector<std::string> parameters_of(const TransverselyIsotropic& law) {
  std::vector<std::string> names{"E", "nu", "E_fibre", "nu_fibre", "mu_fibre"};
  if (law.mu) names.emplace_back("mu");
  return names;
}

Vector6 derivative_of(const Isotropic& law, const std::string& parameter) {
  double mu = 0, lambda = 0;  // derivatives
  const double a = 1 + law.nu, b = 1 - 2 * law.nu;
  if (parameter == "E") {
    mu = 1 / (2 * a);
    lambda = law.nu / (a * b);
  } else {
    mu = -law.E / (2 * a * a);
    lambda = law.E * (1 + 2 * law.nu * law.nu) / (a * a * b * b);  // of nu / ((1 + nu) (1 - 2 nu))
  }
  Vector6 d;
  d << lambda + 2 * mu, lambda, lambda, lambda + 2 * mu, mu, mu;
  return d;
}

// The coefficients are N / ((1 + nu) k), N / ((1 + nu) k), N / k, N / k, mu', mu with k = E'(1 - nu) - 2 nu'^2 E.
Vector6 derivative_of(const TransverselyIsotropic& law, const std::string& parameter) {
  const double E = law.E, F = law.E_fibre, nu = law.nu, n = law.nu_fibre;
  const double k = F * (1 - nu) - 2 * n * n * E, a = 1 + nu;
  const Eigen::Vector4d N(E * (F - n * n * E), E * (n * n * E + nu * F), E * F * n, F * F * (1 - nu));
  Eigen::Vector4d dN = Eigen::Vector4d::Zero();
  double dk = 0, da = 0, d_shear_along = 0, d_shear = 0;
  if (parameter == "E") {
    dN << F - 2 * n * n * E, 2 * n * n * E + nu * F, F * n, 0;
    dk = -2 * n * n;
    if (!law.mu) d_shear = 1 / (2 * a);
  } else if (parameter == "nu") {
    dN << 0, E * F, 0, -F * F;
    dk = -F;
    da = 1;
    if (!law.mu) d_shear = -E / (2 * a * a);
  } else if (parameter == "E_fibre") {
    dN << E, E * nu, E * n, 2 * F * (1 - nu);
    dk = 1 - nu;
  } else if (parameter == "nu_fibre") {
    dN << -2 * n * E * E, 2 * n * E * E, E * F, 0;
    dk = -4 * n * E;
  } else if (parameter == "mu_fibre") {
    d_shear_along = 1;
  } else {  // mu
    d_shear = 1;
  }
  Vector6 d;
  for (int i = 0; i < 4; ++i) {
    const double below = i < 2 ? a * k : k, d_below = i < 2 ? a * dk + da * k : dk;
    d[i] = dN[i] / below - N[i] * d_below / (below * below);
  }
  d[4] = d_shear_along;
  d[5] = d_shear;
  return d;
}

}  // namespace

std::vector<std::string> stiffness_parameters(const Material& material) {
  return std::visit([](const auto& law) { return parameters_of(law); }, material.elasticity);
}

Vector6 stiffness_derivative(const Material& material, const std::string& parameter) {
  std::string known;
  bool found = false;
  for (const std::string& name : stiffness_parameters(material)) {
    found = found || name == parameter;
    known += (known.empty() ? "" : ", ") + name;
  }
  if (!found)
    throw InvalidInput("stiffness_derivative: parameter = \"" + parameter + "\"; must be one of " + known +
                       ", which the stiffness of this material depends on.");
  return std::visit([&](const auto& law) { return derivative_of(law, parameter); }, material.elasticity);
}

}  // namespace plica

#pragma once
#include <string>
#include <vector>

#include "plica/tissue/material.hpp"

namespace plica {

/// The parameters that the stiffness of a material depends on: E, nu, and of transversely isotropic tissue
/// E_fibre, nu_fibre, mu_fibre and, where it is given, mu.
std::vector<std::string> stiffness_parameters(const Material& material);

/// d stiffness_coefficients / d parameter at a valid material; Pa, or dimensionless for a modulus. Where mu is
/// absent it follows E and nu. Throws InvalidInput naming the parameters there are.
Vector6 stiffness_derivative(const Material& material, const std::string& parameter);

}  // namespace plica

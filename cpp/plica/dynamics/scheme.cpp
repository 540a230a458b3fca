#include "plica/dynamics/scheme.hpp"

#include <cmath>

#include "plica/core/error.hpp"

namespace plica {

namespace {

struct Coefficients {
  SchemeCoefficients operator()(const Newmark& scheme) const {
    if (!(scheme.beta > 0 && std::isfinite(scheme.beta)))
      throw InvalidInput("Newmark", "beta", scheme.beta, "", "> 0",
                         "The explicit scheme, beta = 0, is CentralDifferences.");
    if (!(scheme.gamma >= 0.5 && std::isfinite(scheme.gamma)))
      throw InvalidInput("Newmark", "gamma", scheme.gamma, "", ">= 1/2", "Below, energy grows without bound.");
    if (!(2 * scheme.beta >= scheme.gamma))
      throw InvalidInput("Newmark", "beta", scheme.beta, "", ">= gamma / 2", "Unconditional stability needs it.");
    return {0.0, scheme.beta, scheme.gamma};
  }
  SchemeCoefficients operator()(const HilberHughesTaylor& scheme) const {
    const double alpha = scheme.alpha;
    if (!(alpha >= -1.0 / 3.0 - 1e-12 && alpha <= 0.0))
      throw InvalidInput("HilberHughesTaylor", "alpha", alpha, "", "in [-1/3, 0]");
    return {alpha, 0.25 * (1 - alpha) * (1 - alpha), 0.5 - alpha};
  }
  SchemeCoefficients operator()(CentralDifferences) const { return {0.0, 0.0, 0.5}; }
};

}  // namespace

SchemeCoefficients scheme_coefficients(const TimeScheme& scheme) { return std::visit(Coefficients{}, scheme); }

}  // namespace plica

#pragma once
#include <variant>

#include "plica/core/error.hpp"

namespace plica {

/// Newmark's family (Paper A, Eq. 24); the trapezoidal rule by default.
struct Newmark {
  double beta = 0.25;  // > 0, >= gamma / 2
  double gamma = 0.5;  // >= 1/2
};

/// Hilber-Hughes-Taylor: gamma = 1/2 - alpha, beta = (1 - alpha)^2 / 4.
struct HilberHughesTaylor {
  double alpha = -0.3;  // in [-1/3, 0]
};

/// The explicit end of Newmark's family, beta = 0, gamma = 1/2, viscous forces being those of v_n + h a_n: nothing
/// is solved for, and steps are limited (StableStep).
struct CentralDifferences {};

using TimeScheme = std::variant<Newmark, HilberHughesTaylor, CentralDifferences>;

/// The three numbers of a scheme; alpha = 0 for Newmark.
struct SchemeCoefficients {
  double alpha, beta, gamma;
  /// s^2: what an acceleration of the step's end moves of its displacement; 0 where the scheme is explicit.
  double inertia(double step) const { return beta * step * step; }
  /// Of what is at the step's end in what its equation has; -alpha is that of its beginning.
  double weight() const { return 1 + alpha; }
};
/// Throws InvalidInput for parameters outside the ranges above.
SchemeCoefficients scheme_coefficients(const TimeScheme& scheme);

}  // namespace plica

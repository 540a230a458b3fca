#pragma once
#include "plica/tissue/assembly.hpp"
#include "plica/tissue/stretch_law.hpp"

namespace plica {

/// What the slopes of tissue at finite strain can be worth by its mass, without an eigenvalue of the whole: with K
/// and C those of InternalForce on u and v and M the lumped mass, the largest eigenvalue of M^-1 (e K + c C) is
/// below that of a single cell. There y . (e K + c C) y = int H . B H dV with H = dy/dX at a point, and int |H|^2
/// dV
/// <= s sum m |y|^2, s the largest eigenvalue of the cell's Laplacian by its lumped mass: s times the largest
/// eigenvalue of B is a bound.
class SlopeBound {
 public:
  /// Both must outlive it. Throws InvalidInput for tissue that StretchLaw does not take. O(cells).
  SlopeBound(const TetMesh& mesh, const Tissue& tissue);

  struct Largest {
    double value = 0.0;  // infinite where a cell is inside out
    std::int32_t cell = 0;
  };
  /// Of M^-1 (elastic K + viscous C) at displacement u (3 n) m, >= 0.
  Largest at(const Vector& u, double elastic, double viscous) const {
    return largest(u, nullptr, elastic, viscous);
  }
  /// The same of what K and C at u have more than at `known`.
  Largest change(const Vector& known, const Vector& u, double elastic, double viscous) const {
    return largest(u, &known, elastic, viscous);
  }

 private:
  Largest largest(const Vector& u, const Vector* known, double elastic, double viscous) const;

  const TetMesh& mesh_;
  const Tissue& tissue_;
  std::vector<StretchLaw> laws_;
  Vector by_mass_;  // (m) s of each cell, m/kg
};

}  // namespace plica

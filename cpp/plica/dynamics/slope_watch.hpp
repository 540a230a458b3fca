#pragma once
#include <optional>

#include "plica/dynamics/motion.hpp"
#include "plica/dynamics/stable_step.hpp"
#include "plica/tissue/slope_bound.hpp"

namespace plica {

/// Whether central differences stay stable as tissue at finite strain is deformed: the eigenvalue of StableStep
/// with the slopes of its force there. It is found anew only where it may have come above 1, which SlopeBound says
/// of the change of the slopes since it was (docs/theory/explicit.md).
class SlopeWatch {
 public:
  /// Of a motion at finite strain, which must outlive it; inverse_mass (3 n) 1/kg, zero where held.
  SlopeWatch(const Motion& motion, const Vector& inverse_mass);

  /// What a step is too long for.
  struct TooLong {
    double largest;          // s, the largest stable step
    bool with_tissue_alone;  // without what is further
    std::int32_t stiffest;   // the cell with the largest bound
  };
  /// At the displacement u (3 n) m of so many steps, `further` 1/s^2 of stiffness beside the tissue's. It looks at
  /// the slopes every few steps, and in any that moves further than that of the last look did or that does not
  /// follow upon the last. Throws SolveFailed where a cell is
  /// inside out.
  std::optional<TooLong> at(const Vector& u, std::int64_t step, double further);

 private:
  /// With the slopes at u, which must outlive it.
  StableStep stable_at(const Vector& u) const;

  const Motion& motion_;
  const Vector inverse_mass_;
  SlopeBound bound_;
  Vector known_;             // u at which the eigenvalue was found; empty before
  double eigenvalue_ = 0.0;  // at known_
  double change_ = 0.0;      // a bound of what it has grown by since, of the last look
  Vector last_u_;
  double moved_ = 0.0;  // m, the largest of a component in the step of the last look
  std::int64_t last_ = -1, looked_ = 0, next_look_ = 0;
};

}  // namespace plica

#pragma once
#include <array>
#include <optional>

#include "plica/estimation/lane_products.hpp"
#include "plica/solve/triangular_factor.hpp"

namespace plica::estimation {

/// What goes through one pass over the factor: 8 or 16 right-hand sides, x[lanes * unknown + lane].
template <int lanes>
struct LaneForce {
  std::vector<double> r, d;           // b, then b - A x; workspace
  std::array<double, lanes> whole{};  // |b|^2 of each lane
  double shrinks = 0.0;               // the most that a refinement has left of a residual
};

/// A x = b, A symmetric positive definite and constrained by Supports: the factor in single precision with
/// refinement in double until every lane's |b - A x| / |b| is `tolerance`, or within 1e-10 no longer falls. In the
/// first steps and each sixteenth all residuals are computed; between, one that would be below a third of the
/// tolerance by the worst refinement so far is taken for it.
class LaneSolver {
 public:
  /// What it is given must outlive it. Throws SolveFailed where A is not positive definite.
  LaneSolver(const BlockMatrix& K, const std::optional<BlockMatrix>& C, const BlockMatrix& A, FactorPlan plan,
             const std::vector<double>& free, double tolerance);

  /// b = source - K U - C V, zero where an unknown is held.
  template <int lanes>
  void force(const std::vector<double>& U, const std::vector<double>& V, const std::vector<double>& source,
             LaneForce<lanes>& f) const;
  /// x = A^-1 b. `step` names the step in the message of SolveFailed.
  template <int lanes>
  void solve(LaneForce<lanes>& f, std::vector<double>& x, std::ptrdiff_t step) const;

 private:
  /// d ~ A^-1 r.
  template <int lanes>
  void apply(const std::vector<double>& r, std::vector<double>& d) const;
  /// r -= A d; the largest |r| / |b| of all lanes.
  template <int lanes>
  double subtract(const std::vector<double>& d, LaneForce<lanes>& f) const;

  LaneProducts::Matrices matrices_;
  std::ptrdiff_t nodes_;
  const std::vector<double>& free_;
  TriangularFactor factor_;
  double tolerance_;
};

}  // namespace plica::estimation

#include "plica/estimation/packed_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"

namespace plica {
namespace {

constexpr int pack = BlockMatrix::pack;
constexpr int max_refinements = 60;
constexpr double enough = 1e-10;  // where round-off stops the refinement above the tolerance

using Lanes = PackedSolver::Lanes;

Lanes squares(const std::vector<double>& x) {
  Lanes sums{};
  for (std::size_t i = 0; i < x.size(); i += pack)
    for (std::size_t v = 0; v < pack; ++v) sums[v] += x[i + v] * x[i + v];
  return sums;
}

}  // namespace

Lanes PackedSolver::residual(const std::vector<double>& b, const std::vector<double>& x,
                             std::vector<double>& r) const {
  for_chunks(A_.rows() / 3, BlockMatrix::chunk_rows,
             [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
               A_.multiply_rows_packed(begin, end, x.data(), r.data());
               for (std::ptrdiff_t i = 3 * pack * begin; i < 3 * pack * end; ++i) {
                 const auto at = static_cast<std::size_t>(i);
                 r[at] = b[at] - r[at];
               }
             });
  return squares(r);
}

void PackedSolver::solve(const std::vector<double>& b, std::vector<double>& x, std::ptrdiff_t step) const {
  const Lanes whole = squares(b);
  std::vector<double> r(b.size()), d(b.size());
  Lanes left = residual(b, x, r);
  for (std::size_t v = 0; v < pack; ++v) {
    if (left[v] <= whole[v]) continue;
    for (std::size_t i = v; i < x.size(); i += pack) {
      x[i] = 0.0;
      r[i] = b[i];
    }
    left[v] = whole[v];
  }
  double worst = std::numeric_limits<double>::infinity();
  for (int k = 0; k < max_refinements; ++k) {
    const double before = worst;
    worst = 0.0;
    for (std::size_t v = 0; v < pack; ++v) {
      const double share = whole[v] > 0 ? std::sqrt(left[v] / whole[v]) : 0.0;
      if (!std::isfinite(share) || !std::isfinite(whole[v]))
        throw SolveFailed("impulse_responses: step " + number(static_cast<double>(step)) +
                          ": a displacement is not finite. Is the step, or a tissue value, extreme?");
      worst = std::max(worst, share);
    }
    if (worst <= tolerance_ || (k > 1 && worst > 0.5 * before)) break;
    factor_.solve_packed(r.data(), d.data());
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += d[i];
    left = residual(b, x, r);
  }
  if (worst > std::max(tolerance_, enough))
    throw SolveFailed("impulse_responses: step " + number(static_cast<double>(step)) +
                      ": the refined solve stopped at residual " + number(worst) +
                      "; must be <= " + number(std::max(tolerance_, enough)) + ". Try a smaller step.");
}

}  // namespace plica

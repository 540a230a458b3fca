#include "plica/estimation/lane_solver.hpp"

#include <algorithm>
#include <cmath>

#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"

namespace plica::estimation {
namespace {

constexpr int max_refinements = 60;
constexpr double enough = 1e-10;     // where round-off stops the refinement above the tolerance
constexpr double round_off = 1e-11;  // of a residual, below which a refinement tells nothing of the next
constexpr std::ptrdiff_t computed_first = 8, computed_each = 16;
constexpr std::ptrdiff_t chunk = BlockMatrix::chunk_rows;

/// Calls rows(begin, end, squares) in parallel; the sums of their `count` numbers in the order of the chunks.
template <std::size_t count, typename Rows>
std::array<double, count> summed(std::ptrdiff_t nodes, const Rows& rows) {
  std::vector<double> parts(count * static_cast<std::size_t>((nodes + chunk - 1) / chunk));
  for_chunks(nodes, chunk, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t k) {
    rows(begin, end, parts.data() + static_cast<std::ptrdiff_t>(count) * k);
  });
  std::array<double, count> sums{};
  for (std::size_t i = 0; i < parts.size(); ++i) sums[i % count] += parts[i];
  return sums;
}

}  // namespace

LaneSolver::LaneSolver(const BlockMatrix& K, const std::optional<BlockMatrix>& C, const BlockMatrix& A,
                       FactorPlan plan, const std::vector<double>& free, double tolerance)
    : matrices_{A.pattern()->row_start.data(), A.pattern()->column.data(), K.values().data(),
                C ? C->values().data() : nullptr, A.values().data()},
      nodes_(A.rows() / 3),
      free_(free),
      factor_(A, std::move(plan)),
      tolerance_(tolerance) {}

template <int lanes>
void LaneSolver::force(const std::vector<double>& U, const std::vector<double>& V,
                       const std::vector<double>& source, LaneForce<lanes>& f) const {
  const auto rows = lanes == 8 ? lane_products().force8 : lane_products().force16;
  const LaneProducts::Force of{U.data(), V.data(), source.data(), free_.data(), f.r.data()};
  f.whole = summed<lanes>(nodes_, [&](std::ptrdiff_t begin, std::ptrdiff_t end, double* squares) {
    rows(matrices_, of, begin, end, squares);
  });
}

template <int lanes>
void LaneSolver::apply(const std::vector<double>& r, std::vector<double>& d) const {
  if constexpr (lanes == TriangularFactor::pack)
    factor_.solve_packed(r.data(), d.data());
  else
    factor_.solve_wide(r.data(), d.data());
}

template <int lanes>
double LaneSolver::subtract(const std::vector<double>& d, LaneForce<lanes>& f) const {
  const auto rows = lanes == 8 ? lane_products().subtract8 : lane_products().subtract16;
  const auto left = summed<lanes>(nodes_, [&](std::ptrdiff_t begin, std::ptrdiff_t end, double* squares) {
    rows(matrices_, d.data(), f.r.data(), begin, end, squares);
  });
  double worst = 0.0;
  for (std::size_t v = 0; v < lanes; ++v) {
    const double share = f.whole[v] > 0 ? std::sqrt(left[v] / f.whole[v]) : 0.0;
    worst = std::isfinite(share) ? std::max(worst, share) : share;
    if (!std::isfinite(share)) break;
  }
  return worst;
}

template <int lanes>
void LaneSolver::solve(LaneForce<lanes>& f, std::vector<double>& x, std::ptrdiff_t step) const {
  const auto require_finite = [&](double value) {
    if (!std::isfinite(value))
      throw SolveFailed("impulse_responses: step " + number_text(static_cast<double>(step)) +
                        ": a displacement is not finite. Is the step, or a tissue value, extreme?");
  };
  for (const double square : f.whole) require_finite(square);
  const bool computed = step < computed_first || step % computed_each == 0;
  apply<lanes>(f.r, x);
  double share = 1.0;
  for (int k = 0; k < max_refinements; ++k) {
    if (!computed && 3.0 * share * f.shrinks <= tolerance_) return;
    const double before = share;
    share = subtract(k == 0 ? x : f.d, f);
    require_finite(share);
    if (share > round_off) f.shrinks = std::max(f.shrinks, share / before);
    if (share <= tolerance_) return;
    if (k > 1 && share > 0.5 * before) break;
    apply<lanes>(f.r, f.d);
    for_slices(static_cast<std::ptrdiff_t>(x.size()), [&](std::ptrdiff_t at, std::ptrdiff_t count) {
      for (auto i = static_cast<std::size_t>(at); i < static_cast<std::size_t>(at + count); ++i) x[i] += f.d[i];
    });
  }
  if (share > std::max(tolerance_, enough))
    throw SolveFailed("impulse_responses: step " + number_text(static_cast<double>(step)) +
                      ": the refined solve stopped at residual " + number_text(share) +
                      "; must be <= " + number_text(std::max(tolerance_, enough)) + ". Try a smaller step.");
}

template void LaneSolver::force<8>(const std::vector<double>&, const std::vector<double>&,
                                   const std::vector<double>&, LaneForce<8>&) const;
template void LaneSolver::force<16>(const std::vector<double>&, const std::vector<double>&,
                                    const std::vector<double>&, LaneForce<16>&) const;
template void LaneSolver::solve<8>(LaneForce<8>&, std::vector<double>&, std::ptrdiff_t) const;
template void LaneSolver::solve<16>(LaneForce<16>&, std::vector<double>&, std::ptrdiff_t) const;

}  // namespace plica::estimation

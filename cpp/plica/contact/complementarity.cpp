#include "plica/contact/complementarity.hpp"

#include <Eigen/LU>
#include <algorithm>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"

namespace plica {

Complementarity pivot(std::vector<char> active, const ActiveSolve& solve, double gap_tolerance, int most_pivots) {
  constexpr int block_exchanges = 3;
  const auto rows = static_cast<std::ptrdiff_t>(active.size());
  require_at_least("pivot", "the active set", rows, 1);
  require_at_least("pivot", "the most active sets to try", most_pivots, 1);

  Complementarity result;
  Vector p(rows), w(rows);
  std::ptrdiff_t fewest = rows + 1;
  int exchanges_left = block_exchanges;
  std::vector<std::ptrdiff_t> infeasible;
  while (result.pivots < most_pivots) {
    solve(active, p, w);
    require_size("pivot", "p", p.size(), rows);
    require_size("pivot", "w", w.size(), rows);
    ++result.pivots;
    const double force_tolerance = 1e-10 * p.cwiseAbs().maxCoeff();
    infeasible.clear();
    for (std::ptrdiff_t i = 0; i < rows; ++i)
      if (active[i] ? p[i] < -force_tolerance : w[i] < -gap_tolerance) infeasible.push_back(i);
    if (infeasible.empty()) {
      result.converged = true;
      break;
    }
    const auto count = static_cast<std::ptrdiff_t>(infeasible.size());
    if (count < fewest) {
      fewest = count;
      exchanges_left = block_exchanges;
    } else if (exchanges_left > 0) {
      --exchanges_left;
    } else {
      infeasible = {infeasible.back()};
    }
    for (const std::ptrdiff_t i : infeasible) active[i] = !active[i];
  }
  result.force = p.cwiseMax(0.0);
  result.active = std::move(active);
  return result;
}

Complementarity solve_complementarity(const Eigen::MatrixXd& W, const Vector& q, std::vector<char> guess,
                                      double gap_tolerance, int most_pivots) {
  require_size("solve_complementarity", "the rows of W", W.rows(), q.size());
  require_size("solve_complementarity", "the columns of W", W.cols(), q.size());
  require_size("solve_complementarity", "the guess", static_cast<std::ptrdiff_t>(guess.size()), q.size());
  if (q.size() == 0) return {Vector(), {}, 0, true};
  const double regularisation = shared_compliance * W.diagonal().maxCoeff();
  std::vector<std::ptrdiff_t> rows;
  const auto solve = [&](const std::vector<char>& active, Vector& p, Vector& w) {
    rows.clear();
    for (std::size_t i = 0; i < active.size(); ++i)
      if (active[i]) rows.push_back(static_cast<std::ptrdiff_t>(i));
    p.setZero();
    if (!rows.empty()) {
      Eigen::MatrixXd W_active = W(rows, rows);
      W_active.diagonal().array() += regularisation;
      const Vector right = -q(rows);
      const Vector solution = Eigen::PartialPivLU<Eigen::Ref<Eigen::MatrixXd>>(W_active).solve(right);
      if (!solution.allFinite())
        throw SolveFailed(
            "Contact: the compliance of the closed rows is singular. A contact between two fully fixed bodies?");
      p(rows) = solution;
    }
    w.noalias() = W * p + q;
    for (const std::ptrdiff_t i : rows) w[i] = 0.0;
  };
  return pivot(std::move(guess), solve, gap_tolerance, most_pivots);
}

}  // namespace plica

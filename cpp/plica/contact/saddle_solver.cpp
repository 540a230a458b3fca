#include <algorithm>
#include <map>

#include "plica/contact/motion_solver.hpp"
#include "plica/core/error.hpp"
#include "plica/solve/saddle_point.hpp"

namespace plica {

namespace {

class SaddleSolver final : public MotionSolver {
 public:
  SaddleSolver(const BlockMatrix& A, const Supports& supports, const Indices& nodes, KrylovOptions options)
      : MotionSolver(A.rows(), supports, nodes), options_(tightened(options)), saddle_(A, options_) {}

  Complementarity solve(const std::vector<Row>& rows, double scale, std::vector<char> guess, double gap_tolerance,
                        int most_pivots) override {
    const std::vector<Row> free_rows = not_held(rows);
    // Forces of the last active set, of this question or of the one before, by slave.
    const auto slave = [&](std::size_t i) { return rows[i].push.front().node; };
    const auto solve_active = [&](const std::vector<char>& active, Vector& p, Vector& w) {
      std::vector<SaddleRow> closed;
      std::vector<std::ptrdiff_t> place;
      Vector lambda(static_cast<std::ptrdiff_t>(active.size()));
      for (std::size_t i = 0; i < active.size(); ++i) {
        if (!active[i]) continue;
        const Row& row = free_rows[i];
        const auto known = last_force_.find(slave(i));
        lambda[static_cast<std::ptrdiff_t>(closed.size())] = known == last_force_.end() ? 0.0 : -known->second;
        closed.push_back({row.push, row.gap, row.compliance / scale, -row.free / scale});
        place.push_back(static_cast<std::ptrdiff_t>(i));
      }
      lambda.conservativeResize(static_cast<std::ptrdiff_t>(closed.size()));
      p.setZero();
      if (closed.empty())
        forget();
      else
        find(closed, lambda);
      last_force_.clear();
      for (std::size_t k = 0; k < place.size(); ++k) {
        p[place[k]] = -lambda[static_cast<std::ptrdiff_t>(k)];
        last_force_[slave(static_cast<std::size_t>(place[k]))] = p[place[k]];
      }
      set_gaps(rows, free_rows, active, scale, w);
    };
    return pivot(std::move(guess), solve_active, gap_tolerance, most_pivots);
  }

  void forget() override {
    change_.setZero();
    last_force_.clear();
  }

 private:
  /// Forces to 1e-9 at least; below 1e-12 round-off may stand in the way.
  static KrylovOptions tightened(KrylovOptions options) {
    options.tolerance = std::clamp(options.tolerance, 1e-12, 1e-9);
    return options;
  }

  void find(const std::vector<SaddleRow>& closed, Vector& lambda) {
    Convergence end;
    try {
      end = saddle_.solve(closed, change_, lambda);
    } catch (const SolveFailed& failure) {
      throw SolveFailed(std::string("Contact: ") + failure.what());
    }
    if (!end.converged)
      throw SolveFailed("Contact: the saddle point of " + std::to_string(closed.size()) +
                        " closed rows stopped at residual " + number_text(end.residual) + " after " +
                        std::to_string(end.iterations) + " iterations (tolerance " +
                        number_text(options_.tolerance) +
                        "). Try the condensed solver, a smaller step, or a larger max_iterations of "
                        "solver.method.conjugate_gradients.");
  }

  KrylovOptions options_;
  SaddlePoint saddle_;
  std::map<std::int32_t, double> last_force_;  // N, of the last active set, by slave node
};

}  // namespace

std::unique_ptr<ForceSolver> saddle_solver(const BlockMatrix& A, const Supports& supports, const Indices& nodes,
                                           const KrylovOptions& options) {
  return std::make_unique<SaddleSolver>(A, supports, nodes, options);
}

}  // namespace plica

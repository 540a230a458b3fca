#include "plica/contact/force_solver.hpp"
#include "plica/core/error.hpp"

namespace plica {

namespace {

class ExplicitSolver final : public ForceSolver {
 public:
  Complementarity solve(const std::vector<Row>& rows, double /*scale*/, std::vector<char> /*guess*/,
                        double /*gap_tolerance*/, int /*most_pivots*/) override {
    const auto count = static_cast<std::ptrdiff_t>(rows.size());
    Complementarity found{Vector::Zero(count), std::vector<char>(rows.size(), 0), 1, true};
    for (std::ptrdiff_t j = 0; j < count; ++j) {
      const Row& row = rows[static_cast<std::size_t>(j)];
      if (!(row.compliance > 0))
        throw InvalidInput(
            "Contact: a gap that is held exactly needs a solve; must be a penalty in explicit steps.");
      if (!(row.free < 0)) continue;
      found.force[j] = -row.free / row.compliance;
      found.active[static_cast<std::size_t>(j)] = 1;
    }
    return found;
  }

  void move(const std::vector<Row>&, const Vector&, double /*scale*/, const Points& x_free, Points& x) override {
    x = x_free;
  }
};

}  // namespace

std::unique_ptr<ForceSolver> explicit_solver() { return std::make_unique<ExplicitSolver>(); }

}  // namespace plica

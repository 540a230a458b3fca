#include "plica/contact/force_solver.hpp"
#include "plica/core/threads.hpp"

namespace plica {

namespace {

class DirectSolver final : public ForceSolver {
 public:
  DirectSolver(const Factorization& A, const Supports& supports, const Indices& nodes)
      : A_(A), supports_(supports), nodes_(nodes) {}

  Complementarity solve(const std::vector<Row>& rows, double scale, std::vector<char> guess, double gap_tolerance,
                        int most_pivots) override {
    return solve_complementarity(compliance(rows, scale), free_gaps(rows), std::move(guess), gap_tolerance,
                                 most_pivots);
  }

  Eigen::MatrixXd compliance(const std::vector<Row>& rows, double scale) override {
    const auto count = static_cast<std::ptrdiff_t>(rows.size());
    Eigen::MatrixXd W(count, count);
    for_chunks(count, 4, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
      for (std::ptrdiff_t j = begin; j < end; ++j) {
        Vector force = Vector::Zero(supports_.size());
        rows[static_cast<std::size_t>(j)].add_force(1.0, force);
        const Vector moved = displacement(std::move(force));
        for (std::ptrdiff_t i = 0; i < count; ++i)
          W(i, j) = scale * rows[static_cast<std::size_t>(i)].along(moved);
        W(j, j) += rows[static_cast<std::size_t>(j)].compliance;
      }
    });
    return W;
  }

  void move(const std::vector<Row>& rows, const Vector& force, double scale, const Points& x_free,
            Points& x) override {
    Vector nodal = Vector::Zero(supports_.size());
    for (std::size_t j = 0; j < rows.size(); ++j) rows[j].add_force(force[static_cast<std::ptrdiff_t>(j)], nodal);
    const Vector moved = displacement(std::move(nodal));
    for (const std::int32_t node : nodes_)
      x.row(node) = x_free.row(node) + scale * moved.segment<3>(3 * node).transpose();
  }

 private:
  Vector displacement(Vector force) const {
    supports_.project(force);
    return A_.solve(force);
  }

  const Factorization& A_;
  const Supports& supports_;
  Indices nodes_;
};

}  // namespace

std::unique_ptr<ForceSolver> direct_solver(const Factorization& A, const Supports& supports,
                                           const Indices& nodes) {
  return std::make_unique<DirectSolver>(A, supports, nodes);
}

}  // namespace plica

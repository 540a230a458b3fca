#include <algorithm>

#include "plica/contact/motion_solver.hpp"
#include "plica/core/error.hpp"

namespace plica {

namespace {

/// Vectors kept: a cycle that ends before A's own spectrum is resolved (70 iterations of conjugate gradients at
/// the thesis's size) loses the rows and stagnates. 8 n bytes each.
constexpr int restart = 300;

class GmresSolver final : public MotionSolver {
 public:
  GmresSolver(const BlockMatrix& A, const Supports& supports, const Indices& nodes, const KrylovOptions& options)
      : MotionSolver(A.rows(), supports, nodes), A_(A), options_(options), diagonal_(A.rows()) {
    // Rows that nearly repeat others end GMRES above 1e-10. Forces need no more: the motion is solved for again
    // with them, to the tolerance asked for.
    options_.tolerance = std::max(options_.tolerance, 1e-9);
    for (std::int32_t i = 0; i < A.rows() / 3; ++i) {
      const double* block = A.block(A.pattern()->find(i, i));
      for (int c = 0; c < 3; ++c) diagonal_[3 * i + c] = block[4 * c];
    }
  }

  Complementarity solve(const std::vector<Row>& rows, double scale, std::vector<char> guess, double gap_tolerance,
                        int most_pivots) override {
    const std::vector<Row> free_rows = not_held(rows);
    const auto solve_active = [&](const std::vector<char>& active, Vector& p, Vector& w) {
      p.setZero();
      change_.setZero();
      std::vector<std::ptrdiff_t> closed;
      for (std::size_t i = 0; i < active.size(); ++i)
        if (active[i]) closed.push_back(static_cast<std::ptrdiff_t>(i));
      if (!closed.empty()) saddle_point(free_rows, closed, scale, p);
      set_gaps(rows, free_rows, active, scale, w);
    };
    return pivot(std::move(guess), solve_active, gap_tolerance, most_pivots);
  }

 private:
  /// G diag(A)^-1 N^T of a row with itself.
  double own_compliance(const Row& row) const {
    double sum = 0;
    for (const auto& [node, gap] : row.gap)
      for (const auto& [pushed, push] : row.push)
        if (node == pushed) sum += gap.cwiseProduct(push).cwiseQuotient(diagonal_.segment<3>(3 * node)).sum();
    return sum;
  }

  /// [A N^T; G -e - compliance / scale] [change; lambda] = [0; -free / scale], lambda = -p; e, 1e-7 of the
  /// largest entry of the second block, lets rows that depend on others share the force.
  void saddle_point(const std::vector<Row>& rows, const std::vector<std::ptrdiff_t>& closed, double scale,
                    Vector& p) {
    const std::ptrdiff_t n = A_.rows(), m = static_cast<std::ptrdiff_t>(closed.size());
    Vector P(n + m), b = Vector::Zero(n + m), y = Vector::Zero(n + m), head(n), product(n);
    P.head(n) = diagonal_;
    for (std::ptrdiff_t i = 0; i < m; ++i) {
      const Row& row = rows[static_cast<std::size_t>(closed[i])];
      P[n + i] = own_compliance(row) + row.compliance / scale;  // Eq. (29), second block
      b[n + i] = -row.free / scale;
    }
    const double regularisation = 1e-7 * P.tail(m).maxCoeff();
    if (!(P.tail(m).minCoeff() > 0.0))
      throw SolveFailed(
          "Contact: the compliance of the closed rows is singular. A contact between two fully fixed bodies?");
    const auto apply = [&](const Vector& in, Vector& out) {
      out.resize(n + m);
      head = in.head(n);
      A_.multiply(head, product);
      out.head(n) = product;
      for (std::ptrdiff_t i = 0; i < m; ++i) {
        const Row& row = rows[static_cast<std::size_t>(closed[i])];
        for (const auto& [node, vector] : row.push) out.segment<3>(3 * node) += in[n + i] * vector;
        out[n + i] = row.along(head) - (regularisation + row.compliance / scale) * in[n + i];
      }
    };
    const Convergence end = gmres(apply, P, b, y, options_, restart);
    if (!end.converged)
      throw SolveFailed(
          "Contact: GMRES stopped at residual " + number_text(end.residual) + " after " +
          std::to_string(end.iterations) + " iterations (tolerance " + number_text(options_.tolerance) +
          "). Try the condensed solver, or a larger max_iterations of solver.method.conjugate_gradients.");
    change_ = y.head(n);
    for (std::ptrdiff_t i = 0; i < m; ++i) p[closed[i]] = -y[n + i];
  }

  const BlockMatrix& A_;
  KrylovOptions options_;
  Vector diagonal_;
};

}  // namespace

std::unique_ptr<ForceSolver> gmres_solver(const BlockMatrix& A, const Supports& supports, const Indices& nodes,
                                          const KrylovOptions& options) {
  return std::make_unique<GmresSolver>(A, supports, nodes, options);
}

}  // namespace plica

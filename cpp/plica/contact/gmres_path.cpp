#include <algorithm>

#include "plica/contact/path.hpp"
#include "plica/core/error.hpp"

namespace plica {

namespace {

/// Vectors kept: a cycle that ends before A's own spectrum is resolved (70 iterations of conjugate gradients at
/// the thesis's size) loses the rows and stagnates. 8 n bytes each.
constexpr int restart = 300;

/// A pair's row of G and column of N^T, held unknowns left out.
struct Row {
  std::array<std::int32_t, 12> unknown{};
  std::array<double, 12> gap{};    // along the linear gap's direction
  std::array<double, 12> force{};  // along the normal
};

class GmresPath final : public ContactPath {
 public:
  GmresPath(const BlockMatrix& A, const Supports& supports, const Indices& nodes, const KrylovOptions& options)
      : A_(A), supports_(supports), nodes_(nodes), options_(options), diagonal_(A.rows()), change_(A.rows()) {
    // Rows that nearly repeat others end GMRES above 1e-10. Forces need no more: the motion is solved for again
    // with them, to the tolerance asked for.
    options_.tolerance = std::max(options_.tolerance, 1e-9);
    for (std::int32_t i = 0; i < A.rows() / 3; ++i) {
      const double* block = A.block(A.pattern()->find(i, i));
      for (int c = 0; c < 3; ++c) diagonal_[3 * i + c] = block[4 * c];
    }
  }

  Complementarity solve(const std::vector<Pair>& pairs, const LinearGaps& gaps, double scale,
                        std::vector<char> guess, double gap_tolerance, int most_pivots) override {
    rows_.clear();
    for (std::size_t i = 0; i < pairs.size(); ++i) rows_.push_back(row_of(pairs[i], gaps.direction[i]));
    const auto solve_active = [&](const std::vector<char>& active, Vector& p, Vector& w) {
      p.setZero();
      change_.setZero();
      std::vector<std::ptrdiff_t> closed;
      for (std::size_t i = 0; i < active.size(); ++i)
        if (active[i]) closed.push_back(static_cast<std::ptrdiff_t>(i));
      if (!closed.empty()) saddle_point(pairs, closed, gaps.free, scale, p);
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        w[i] = gaps.free[i] + scale * apply_row(rows_[i], change_);
        if (active[i]) w[i] = 0.0;
      }
    };
    return pivot(std::move(guess), solve_active, gap_tolerance, most_pivots);
  }

  void move(const std::vector<Pair>&, const Vector&, double scale, const Points& x_free, Points& x) override {
    for (std::ptrdiff_t i = 0; i < nodes_.size(); ++i)
      x.row(nodes_[i]) = x_free.row(nodes_[i]) + scale * change_.segment<3>(3 * nodes_[i]).transpose();
  }

 private:
  Row row_of(const Pair& pair, const Vector3& direction) const {
    Row row;
    for (int k = 0; k < 4; ++k) {
      const std::int32_t node = k == 0 ? pair.slave : pair.master[k - 1];
      const double weight = k == 0 ? 1.0 : -pair.weights[k - 1];
      for (int c = 0; c < 3; ++c) {
        row.unknown[3 * k + c] = 3 * node + c;
        if (supports_.fixed(3 * node + c)) continue;
        row.gap[3 * k + c] = weight * direction[c];
        row.force[3 * k + c] = weight * pair.normal[c];
      }
    }
    return row;
  }

  static double apply_row(const Row& row, const Vector& v) {
    double sum = 0;
    for (int k = 0; k < 12; ++k) sum += row.gap[k] * v[row.unknown[k]];
    return sum;
  }

  double coupling(const Row& a, const Row& b) const {
    double sum = 0;
    for (int i = 0; i < 12; ++i)
      for (int j = 0; j < 12; ++j)
        if (a.unknown[i] == b.unknown[j]) sum += a.gap[i] * b.force[j] / diagonal_[a.unknown[i]];
    return sum;
  }

  /// [A N^T; G -e - 1/(scale stiffness)] [change; lambda] = [0; -gap_free / scale], lambda = -p; e, 1e-7 of the
  /// largest entry of the second block, lets rows that depend on others share the force.
  void saddle_point(const std::vector<Pair>& pairs, const std::vector<std::ptrdiff_t>& closed,
                    const Vector& gap_free, double scale, Vector& p) {
    const std::ptrdiff_t n = A_.rows(), m = static_cast<std::ptrdiff_t>(closed.size());
    Vector P(n + m), b = Vector::Zero(n + m), y = Vector::Zero(n + m), head(n), product(n);
    P.head(n) = diagonal_;
    for (std::ptrdiff_t i = 0; i < m; ++i) {
      P[n + i] = coupling(rows_[closed[i]], rows_[closed[i]]);  // Eq. (29), second block
      b[n + i] = -gap_free[closed[i]] / scale;
    }
    const double regularisation = 1e-7 * P.tail(m).maxCoeff();
    const auto apply = [&](const Vector& in, Vector& out) {
      out.resize(n + m);
      head = in.head(n);
      A_.multiply(head, product);
      out.head(n) = product;
      for (std::ptrdiff_t i = 0; i < m; ++i) {
        const Row& row = rows_[closed[i]];
        for (int k = 0; k < 12; ++k) out[row.unknown[k]] += row.force[k] * in[n + i];
        out[n + i] = apply_row(row, head) - regularisation * in[n + i];
        const double stiffness = pairs[closed[i]].stiffness;
        if (stiffness > 0) out[n + i] -= in[n + i] / (scale * stiffness);
      }
    };
    const Convergence end = gmres(apply, P, b, y, options_, restart);
    if (!end.converged)
      throw SolveFailed("Contact: GMRES stopped at residual " + number(end.residual) + " after " +
                        std::to_string(end.iterations) + " iterations (tolerance " + number(options_.tolerance) +
                        "). Try the condensed solver, or a larger max_iterations.");
    change_ = y.head(n);
    for (std::ptrdiff_t i = 0; i < m; ++i) p[closed[i]] = -y[n + i];
  }

  const BlockMatrix& A_;
  const Supports& supports_;
  Indices nodes_;
  KrylovOptions options_;
  Vector diagonal_;
  Vector change_;  // (3 n) a - a_free of the last active set
  std::vector<Row> rows_;
};

}  // namespace

std::unique_ptr<ContactPath> gmres_path(const BlockMatrix& A, const Supports& supports, const Indices& nodes,
                                        const KrylovOptions& options) {
  return std::make_unique<GmresPath>(A, supports, nodes, options);
}

}  // namespace plica

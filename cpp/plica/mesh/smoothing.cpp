#include "plica/mesh/smoothing.hpp"

#include <Eigen/Dense>
#include <limits>

#include "plica/core/require.hpp"
#include "plica/mesh/edges.hpp"

namespace plica {

namespace {

/// The cells at one node, and what they are worth with the node at p.
class Star {
 public:
  /// The square of `least` is taken of volumes that are not above it (see smooth).
  Star(const Points& x, const Cells& cells, const std::vector<Eigen::Index>& own, std::int32_t node, double least)
      : least_(least) {
    for (const Eigen::Index e : own) {
      std::array<Vector3, 3> rest;  // p rest is positively oriented
      int k = 0;
      while (cells(e, k) != node) ++k;
      constexpr std::array<std::array<int, 3>, 4> others{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
      for (int i = 0; i < 3; ++i) rest[i] = x.row(cells(e, others[k][i]));
      const double sides = (rest[1] - rest[0]).squaredNorm() + (rest[2] - rest[1]).squaredNorm() +
                           (rest[0] - rest[2]).squaredNorm();
      cells_.push_back({rest, (rest[1] - rest[0]).cross(rest[2] - rest[0]), sides});
    }
  }

  double operator()(const Vector3& p) const {
    double sum = 0;
    for (const auto& cell : cells_) {
      const double volume = cell.normal.dot(cell.rest[0] - p);
      if (least_ == 0 && !(volume > 0)) return std::numeric_limits<double>::infinity();
      double sides = cell.sides;
      for (const Vector3& q : cell.rest) sides += (q - p).squaredNorm();
      const double ratio = volume / (sides * std::sqrt(sides));
      const double held = least_ == 0 ? ratio : 0.5 * (ratio + std::sqrt(ratio * ratio + 4 * least_ * least_));
      sum += 1 / (held * held);
    }
    return sum;
  }

 private:
  struct Cell {
    std::array<Vector3, 3> rest;
    Vector3 normal;
    double sides;
  };
  std::vector<Cell> cells_;
  double least_;
};

/// The least 6 V / (l^2)^(3/2) of the cells; 0.048 where regular.
double least_ratio(const Points& x, const Cells& cells) {
  const Vector volumes = signed_volumes(x, cells);
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index e = 0; e < cells.rows(); ++e) {
    double sides = 0;
    for (const auto& [a, b] : tet_edges) sides += (x.row(cells(e, a)) - x.row(cells(e, b))).squaredNorm();
    least = std::min(least, 6 * volumes[e] / (sides * std::sqrt(sides)));
  }
  return least;
}

Vector3 placed(Vector3 p, const Freedom& freedom) {
  if (freedom.cylinder > 0) p.head<2>() *= freedom.cylinder / p.head<2>().norm();
  return p;
}

/// Orthonormal directions in which the node moves, as columns; on a cylinder the tangents.
Eigen::Matrix<double, 3, Eigen::Dynamic> directions(const Vector3& p, const Freedom& freedom) {
  Eigen::Matrix<double, 3, Eigen::Dynamic> columns(3, 0);
  const auto append = [&](const Vector3& d) {
    columns.conservativeResize(3, columns.cols() + 1);
    columns.col(columns.cols() - 1) = d;
  };
  if (freedom.cylinder > 0) {
    if (freedom.along[0] > 0 && freedom.along[1] > 0) append(Vector3(-p[1], p[0], 0) / freedom.cylinder);
    if (freedom.along[2] > 0) append(Vector3::UnitZ());
  } else {
    for (int d = 0; d < 3; ++d)
      if (freedom.along[d] > 0) append(Vector3::Unit(d));
  }
  return columns;
}

/// One Newton step with derivatives from differences, halved until it improves; down the gradient where the second
/// derivatives are not positive.
Vector3 improved(const Star& star, const Vector3& p, const Freedom& freedom, double length) {
  const auto columns = directions(p, freedom);
  const Eigen::Index n = columns.cols();
  const double h = 1e-4 * length, here = star(p);
  const auto at = [&](const Vector& u) { return star(placed(p + columns * u, freedom)); };
  const auto unit = [&](Eigen::Index i) -> Vector { return h * Vector::Unit(n, i); };
  Vector gradient(n);
  Eigen::MatrixXd second(n, n);
  Vector forward(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double back = at(-unit(i));
    forward[i] = at(unit(i));
    gradient[i] = (forward[i] - back) / (2 * h);
    second(i, i) = (forward[i] - 2 * here + back) / (h * h);
  }
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < i; ++j)
      second(i, j) = second(j, i) = (at(unit(i) + unit(j)) - forward[i] - forward[j] + here) / (h * h);
  if (!gradient.allFinite() || !second.allFinite() || gradient.norm() == 0) return p;
  const Eigen::LDLT<Eigen::MatrixXd> factor(second);
  Vector step =
      factor.isPositive() ? Vector(-factor.solve(gradient)) : Vector(-0.1 * length * gradient.normalized());
  if (step.norm() > 0.5 * length) step *= 0.5 * length / step.norm();
  for (int halving = 0; halving < 8; ++halving, step *= 0.5)
    if (at(step) < here) return placed(p + columns * step, freedom);
  return p;
}

}  // namespace

void smooth_mesh(Points& x, const Cells& cells, const std::vector<Freedom>& freedom, int sweeps) {
  require_size("smooth_mesh", "a cell", cells.cols(), 4, 10);
  require_indices("smooth_mesh", "node of a cell", cells, x.rows());
  require_size("smooth_mesh", "freedom", static_cast<std::ptrdiff_t>(freedom.size()), x.rows());
  std::vector<std::vector<Eigen::Index>> own(x.rows());
  std::vector<double> length(x.rows(), std::numeric_limits<double>::infinity());  // the shortest edge at a node
  for (Eigen::Index e = 0; e < cells.rows(); ++e) {
    for (const std::int32_t node : cells.row(e)) own[node].push_back(e);
    for (const auto& [a, b] : tet_edges)
      for (const std::int32_t node : {cells(e, a), cells(e, b)})
        length[node] = std::min(length[node], (x.row(cells(e, a)) - x.row(cells(e, b))).norm());
  }
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    constexpr double flat = 1e-3;
    const double worst = least_ratio(x, cells), least = worst > 0 ? 0 : std::sqrt(flat * (flat - worst));
    for (std::int32_t node = 0; node < x.rows(); ++node)
      if (freedom[node].along.sum() > 0)
        x.row(node) = improved(Star(x, cells, own[node], node, least), x.row(node), freedom[node], length[node]);
  }
}

}  // namespace plica

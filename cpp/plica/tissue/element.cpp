#include "plica/tissue/element.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

namespace plica {
namespace {

constexpr int tetrahedron_edges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
constexpr int triangle_edges[3][2] = {{0, 1}, {1, 2}, {2, 0}};

// rows 0..5 of D B for the gradient g of one shape function; (6, 3) row-major.
inline void stress_rows(const double* D, const double* g, double* out) {
  for (int r = 0; r < 6; ++r) {
    const double* d = D + 6 * r;
    out[3 * r] = d[0] * g[0] + d[3] * g[1] + d[5] * g[2];
    out[3 * r + 1] = d[1] * g[1] + d[3] * g[0] + d[4] * g[2];
    out[3 * r + 2] = d[2] * g[2] + d[4] * g[1] + d[5] * g[0];
  }
}

// out += weight B^T s for the gradient g of one shape function and the stress rows s of another.
inline void add_block(const double* g, const double* s, double weight, double* out) {
  const double x = weight * g[0], y = weight * g[1], z = weight * g[2];
  for (int c = 0; c < 3; ++c) {
    out[c] += x * s[c] + y * s[9 + c] + z * s[15 + c];
    out[3 + c] += y * s[3 + c] + x * s[9 + c] + z * s[12 + c];
    out[6 + c] += z * s[6 + c] + y * s[12 + c] + x * s[15 + c];
  }
}

// With straight sides grad N_a = sum_p (dN_a/dl_p) grad l_p, so that K_ab is a sum of the blocks of the
// linear element: K_ab = sum_pq c_abpq (V grad l_p . D . grad l_q), c the mean of (dN_a/dl_p)(dN_b/dl_q).
struct StraightTerm {
  int pair;    // 10 a + b
  int linear;  // 4 p + q
  double c;
};

struct QuadraticTables {
  Eigen::Matrix<double, 10, 1> load = Eigen::Matrix<double, 10, 1>::Zero();    // shares of the volume
  Eigen::Matrix<double, 10, 10> mass = Eigen::Matrix<double, 10, 10>::Zero();  // shares of the volume
  std::vector<StraightTerm> stiffness;
  std::vector<ShapeValues> values;  // at the 15 points
  std::vector<ShapeSlopes> slopes;  // at the 15 points
  ShapeSlopes centroid_slopes = quadratic_slopes({0.25, 0.25, 0.25, 0.25});

  QuadraticTables() {
    for (const auto& point : tetrahedron_rule_degree_5()) {
      values.push_back(quadratic_shapes(point.at));
      slopes.push_back(quadratic_slopes(point.at));
      load += point.weight * values.back();
      mass += point.weight * (values.back() * values.back().transpose()).eval();  // symmetric to the last bit
    }
    // dN_a/dl_p vanishes identically unless p is an end of the edge of a, or a itself.
    const auto corners_of = [](int a) -> std::vector<int> {
      if (a < 4) return {a};
      return {tetrahedron_edges[a - 4][0], tetrahedron_edges[a - 4][1]};
    };
    for (int a = 0; a < 10; ++a) {
      for (int b = a; b < 10; ++b) {
        for (int p : corners_of(a)) {
          for (int q : corners_of(b)) {
            double c = 0;
            for (const auto& point : tetrahedron_rule_degree_2()) {
              const ShapeSlopes slope = quadratic_slopes(point.at);
              c += point.weight * slope(a, p) * slope(b, q);
            }
            stiffness.push_back({10 * a + b, 4 * p + q, c});
          }
        }
      }
    }
  }
};

const QuadraticTables& quadratic_tables() {
  static const QuadraticTables tables;
  return tables;
}

// Blocks V grad l_p . D . grad l_q of the linear element, all (4, 4) of them or those with q >= p.
template <bool upper_only>
void linear_blocks(const double* gradients, double volume, const double* D, double* out) {
  for (int q = 0; q < 4; ++q) {
    double stress[18];
    stress_rows(D, gradients + 3 * q, stress);
    for (int p = 0; p < (upper_only ? q + 1 : 4); ++p) {
      double* block = out + 9 * (4 * p + q);
      std::fill(block, block + 9, 0.0);
      add_block(gradients + 3 * p, stress, volume, block);
    }
  }
}

}  // namespace

ShapeValues quadratic_shapes(const std::array<double, 4>& at) {
  ShapeValues N;
  for (int i = 0; i < 4; ++i) N[i] = at[i] * (2 * at[i] - 1);
  for (int e = 0; e < 6; ++e) N[4 + e] = 4 * at[tetrahedron_edges[e][0]] * at[tetrahedron_edges[e][1]];
  return N;
}

ShapeSlopes quadratic_slopes(const std::array<double, 4>& at) {
  ShapeSlopes slopes = ShapeSlopes::Zero();
  for (int i = 0; i < 4; ++i) slopes(i, i) = 4 * at[i] - 1;
  for (int e = 0; e < 6; ++e) {
    const int i = tetrahedron_edges[e][0], j = tetrahedron_edges[e][1];
    slopes(4 + e, i) = 4 * at[j];
    slopes(4 + e, j) = 4 * at[i];
  }
  return slopes;
}

Eigen::Matrix<double, 6, 1> triangle_shapes(const std::array<double, 3>& at) {
  Eigen::Matrix<double, 6, 1> N;
  for (int i = 0; i < 3; ++i) {
    N[i] = at[i] * (2 * at[i] - 1);
    N[3 + i] = 4 * at[triangle_edges[i][0]] * at[triangle_edges[i][1]];
  }
  return N;
}

Eigen::Matrix<double, 6, 3> triangle_slopes(const std::array<double, 3>& at) {
  Eigen::Matrix<double, 6, 3> slopes = Eigen::Matrix<double, 6, 3>::Zero();
  for (int e = 0; e < 3; ++e) {
    const int i = triangle_edges[e][0], j = triangle_edges[e][1];
    slopes(e, e) = 4 * at[e] - 1;
    slopes(3 + e, i) = 4 * at[j];
    slopes(3 + e, j) = 4 * at[i];
  }
  return slopes;
}

Element::Element(int order) : order_(order) {}

void Element::place(const Points& points, const std::int32_t* cell) {
  for (int a = 0; a < nodes(); ++a) x_.row(a) = points.row(cell[a]);
  curved_ = false;
  for (int e = 0; order_ == 2 && e < 6 && !curved_; ++e) {
    const auto first = x_.row(tetrahedron_edges[e][0]), second = x_.row(tetrahedron_edges[e][1]);
    const double off = (x_.row(4 + e) - 0.5 * (first + second)).squaredNorm();
    curved_ = off > 1e-20 * (second - first).squaredNorm();
  }
  points_.clear();
  if (curved_) {
    volume_ = 0;
    const auto& rule = tetrahedron_rule_degree_5();
    for (std::size_t i = 0; i < rule.size(); ++i) {
      points_.push_back(evaluate(quadratic_tables().slopes[i], rule[i].weight));
      volume_ += points_.back().weight;
    }
    return;
  }
  const Vector3 first = x_.row(1) - x_.row(0), second = x_.row(2) - x_.row(0), third = x_.row(3) - x_.row(0);
  const Vector3 normal = second.cross(third);
  const double determinant = first.dot(normal);
  volume_ = determinant / 6;
  gradients_.row(1) = normal / determinant;
  gradients_.row(2) = third.cross(first) / determinant;
  gradients_.row(3) = first.cross(second) / determinant;
  gradients_.row(0) = -(gradients_.row(1) + gradients_.row(2) + gradients_.row(3));
}

Element::Point Element::evaluate(const ShapeSlopes& slopes, double share) const {
  Eigen::Matrix<double, 10, 3> local;  // dN/dxi_k, xi_k = l_k for k = 1, 2, 3 and l_0 = 1 - sum
  for (int k = 0; k < 3; ++k) local.col(k) = slopes.col(k + 1) - slopes.col(0);
  const Matrix3 J = x_.transpose() * local;
  Point point;
  point.gradients = local * J.inverse();
  point.weight = share * J.determinant() / 6;
  return point;
}

double Element::least_jacobian() const {
  if (!curved_) return volume_;
  const auto& rule = tetrahedron_rule_degree_5();
  double least = points_[0].weight / rule[0].weight;
  for (std::size_t i = 1; i < rule.size(); ++i) least = std::min(least, points_[i].weight / rule[i].weight);
  return least;
}

void Element::load(double* out) const {
  if (order_ == 1) {
    std::fill(out, out + 4, volume_ / 4);
    return;
  }
  Eigen::Map<ShapeValues> result(out);
  result = volume_ * quadratic_tables().load;
  if (!curved_) return;
  result.setZero();
  for (std::size_t i = 0; i < points_.size(); ++i) result += points_[i].weight * quadratic_tables().values[i];
}

void Element::mass(double* out) const {
  if (order_ == 1) {
    for (int i = 0; i < 16; ++i) out[i] = volume_ / (i % 5 == 0 ? 10 : 20);
    return;
  }
  Eigen::Map<Eigen::Matrix<double, 10, 10>> result(out);
  if (!curved_) {
    result = volume_ * quadratic_tables().mass;
    return;
  }
  result.setZero();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const ShapeValues& N = quadratic_tables().values[i];
    result += points_[i].weight * (N * N.transpose()).eval();  // symmetric to the last bit
  }
}

void Element::lumped_mass(double density, double* out) const {
  double all[100];
  const int n = nodes();
  mass(all);
  // Row sums of the linear element are V / 4 each, which its scaled diagonal is as well.
  double trace = 0;
  for (int a = 0; a < n; ++a) trace += all[a * n + a];
  const double scale = density * volume() / trace;
  for (int a = 0; a < n; ++a) out[a] = scale * all[a * n + a];
}

void Element::stiffness(const Matrix6& D, double* out) const {
  if (order_ == 1) {
    linear_blocks<true>(gradients_.data(), volume_, D.data(), out);
    return;
  }
  std::fill(out, out + 900, 0.0);
  if (!curved_) {
    double linear[144];
    linear_blocks<false>(gradients_.data(), volume_, D.data(), linear);
    for (const StraightTerm& term : quadratic_tables().stiffness) {
      double* block = out + 9 * term.pair;
      const double* part = linear + 9 * term.linear;
      for (int i = 0; i < 9; ++i) block[i] += term.c * part[i];
    }
    return;
  }
  for (const Point& point : points_) {
    for (int b = 0; b < 10; ++b) {
      double stress[18];
      stress_rows(D.data(), point.gradients.data() + 3 * b, stress);
      for (int a = 0; a <= b; ++a) {
        add_block(point.gradients.data() + 3 * a, stress, point.weight, out + 9 * (10 * a + b));
      }
    }
  }
}

Eigen::Matrix<double, Eigen::Dynamic, 3> Element::gradients(const std::array<double, 4>& at) const {
  if (order_ == 1) return gradients_;
  return evaluate(quadratic_slopes(at), 1.0).gradients;
}

double Element::measure(const std::array<double, 4>& at) const {
  return curved_ ? evaluate(quadratic_slopes(at), 1.0).weight : volume_;
}

Eigen::Matrix<double, Eigen::Dynamic, 3> Element::centroid_gradients() const {
  if (order_ == 1) return gradients_;
  return evaluate(quadratic_tables().centroid_slopes, 1.0).gradients;
}

void add_symmetric_blocks(const double* blocks, int nodes, const std::int32_t* entries, double* values) {
  for (int a = 0; a < nodes; ++a) {
    const double* own = blocks + 9 * (nodes * a + a);
    double* target = values + 9 * static_cast<std::ptrdiff_t>(entries[nodes * a + a]);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) target[3 * i + j] += own[i <= j ? 3 * i + j : 3 * j + i];
    }
    for (int b = a + 1; b < nodes; ++b) {
      const double* block = blocks + 9 * (nodes * a + b);
      double* upper = values + 9 * static_cast<std::ptrdiff_t>(entries[nodes * a + b]);
      double* lower = values + 9 * static_cast<std::ptrdiff_t>(entries[nodes * b + a]);
      for (int i = 0; i < 9; ++i) upper[i] += block[i];
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) lower[3 * j + i] += block[3 * i + j];
      }
    }
  }
}

}  // namespace plica

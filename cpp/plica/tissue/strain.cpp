#include "plica/tissue/strain.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"
#include "plica/mesh/edges.hpp"
#include "plica/tissue/element.hpp"

namespace plica {

namespace {

constexpr std::ptrdiff_t chunk_size = 256;
constexpr double lowered = 0.8;  // a cut under the last percentile: strains change by less than that in most steps

using Nodes = Eigen::Matrix<double, 3, 10>;   // a vector at each node of a cell
using Slopes = Eigen::Matrix<double, 3, 12>;  // d/dxi_k at each point, side by side; xi_k = l_k, k = 1, 2, 3
constexpr int shared[4][4] = {{0, 4, 6, 7}, {4, 1, 5, 8}, {6, 5, 2, 9}, {7, 8, 9, 3}};  // node between corners

/// Of quadratic shape functions: d/dl_i = (4 l_i - 1) u_i + 4 sum_j l_j u_ij, where point p has l_p = a and else
/// b: (4 b - 1) u_i + 4 b sum_j u_ij + 4 (a - b) u_ip, with u_ii = u_i.
Slopes slopes_at_points(const Nodes& u) {
  static const double b = tetrahedron_rule_degree_2()[0].at[1], a = tetrahedron_rule_degree_2()[0].at[0];
  Eigen::Matrix<double, 3, 4> common;
  for (int i = 0; i < 4; ++i) {
    Vector3 sum = Vector3::Zero();
    for (int j = 0; j < 4; ++j)
      if (j != i) sum += u.col(shared[i][j]);
    common.col(i) = (4 * b - 1) * u.col(i) + 4 * b * sum;
  }
  Slopes slopes;
  for (int p = 0; p < 4; ++p)
    for (int k = 1; k < 4; ++k)
      slopes.col(3 * p + k - 1) =
          common.col(k) - common.col(0) + 4 * (a - b) * (u.col(shared[k][p]) - u.col(shared[0][p]));
  return slopes;
}

/// Middles of the sides are off by less than 1e-10 of their length, as Element has it.
bool straight_sides(const Nodes& x) {
  for (int e = 0; e < 6; ++e) {
    const Vector3 a = x.col(tet_edges[e][0]), b = x.col(tet_edges[e][1]);
    if ((x.col(4 + e) - 0.5 * (a + b)).squaredNorm() > 1e-20 * (b - a).squaredNorm()) return false;
  }
  return true;
}

/// eps : eps of the gradient H, without cancellation in a rotation.
double squared_norm_of_small_strain(const Matrix3& H) {
  const double xy = H(0, 1) + H(1, 0), yz = H(1, 2) + H(2, 1), zx = H(2, 0) + H(0, 2);
  return H(0, 0) * H(0, 0) + H(1, 1) * H(1, 1) + H(2, 2) * H(2, 2) + 0.5 * (xy * xy + yz * yz + zx * zx);
}

Matrix3 strain_of(const Matrix3& H, StrainMeasure measure) {
  const Matrix3 small = 0.5 * (H + H.transpose());
  if (measure == StrainMeasure::small) return small;
  return small + 0.5 * H.transpose() * H;
}

/// The largest of |eigenvalues|.
double spectral_norm(const Matrix3& symmetric) {
  Eigen::SelfAdjointEigenSolver<Matrix3> solver;
  solver.computeDirect(symmetric, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().cwiseAbs().maxCoeff();
}

double norm(const Matrix3& A) { return std::sqrt(spectral_norm(A.transpose() * A)); }

/// c_p = (l_p - b) / (a - b) at node n: a field that is linear in the cell is there sum_p c_p times that at point
/// p.
double weight_at_node(int n, int p) {
  static const double b = tetrahedron_rule_degree_2()[0].at[1], a = tetrahedron_rule_degree_2()[0].at[0];
  double l = n == p ? 1.0 : 0.0;
  if (n >= 4) l = tet_edges[n - 4][0] == p || tet_edges[n - 4][1] == p ? 0.5 : 0.0;
  return (l - b) / (a - b);
}

/// What |grad u| can grow by from the points to a node of a cell: du/dxi is linear in it, so grad u there is
/// sum_p c_p grad u_p J_p J_n^-1; with straight sides J is one. Infinite where the cell is folded at rest.
double growth_to_nodes(const Slopes& J) {
  double growth = 0.0;
  for (int n = 0; n < 10; ++n) {
    Matrix3 at = Matrix3::Zero();
    for (int p = 0; p < 4; ++p) at += weight_at_node(n, p) * J.middleCols<3>(3 * p);
    if (!(at.determinant() > 0)) return std::numeric_limits<double>::infinity();
    double sum = 0.0;
    for (int p = 0; p < 4; ++p)
      sum += std::abs(weight_at_node(n, p)) * norm(J.middleCols<3>(3 * p) * at.inverse());
    growth = std::max(growth, sum);
  }
  return growth;
}

/// Half of a cut; in the end none, which all points reach.
double next_lower(double cut) { return cut > 1e-9 ? 0.5 * cut : 0.0; }

/// The square of a cut, less round-off: which readings are looked at must not depend on that.
double below(double cut) { return (1 - 1e-12) * cut * cut; }

/// The value that is exceeded in no more than `beyond` m^3, where enough of it lies at or above the cut.
template <class Readings>
std::optional<double> percentile(Readings& readings, double beyond) {
  std::sort(readings.begin(), readings.end(), [](const auto& a, const auto& b) {
    return a.value > b.value || (a.value == b.value && a.point < b.point);
  });
  double volume = 0.0;
  for (const auto& reading : readings)
    if ((volume += reading.volume) > beyond) return reading.value;
  return std::nullopt;
}

}  // namespace

StrainGauge::StrainGauge(const TetMesh& mesh, StrainMeasure measure)
    : mesh_(mesh), measure_(measure), points_(mesh.order() == 2 ? 4 : 1) {
  require_size("StrainGauge", "a row of cells", mesh.cells.cols(), 4, 10);
  require_at_least("StrainGauge", "cells", mesh.cell_count(), 1);
  require_indices("StrainGauge", "node of a cell", mesh.cells, mesh.node_count());
  const auto nodes = static_cast<int>(mesh.cells.cols());
  Nodes x;
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c) {
    first_.push_back(static_cast<std::int32_t>(maps_.size()));
    for (int a = 0; a < nodes; ++a) x.col(a) = mesh.points.row(mesh.cells(c, a)).transpose();
    Slopes J;
    if (points_ == 1)
      for (int k = 0; k < 3; ++k) J.col(k) = x.col(k + 1) - x.col(0);
    else
      J = slopes_at_points(x);
    const bool one = points_ == 1 || straight_sides(x);
    for (int p = 0; p < (one ? 1 : points_); ++p) {
      const Matrix3 at = J.middleCols<3>(3 * p);
      maps_.push_back({at.inverse(), at.determinant() / 6 / points_});
      volume_ += (one ? points_ : 1) * maps_.back().volume;
    }
    if (points_ == 1)
      growth_.push_back(maps_.back().volume > 0 ? 1.0 : std::numeric_limits<double>::infinity());
    else
      growth_.push_back(growth_to_nodes(J));
  }
  first_.push_back(static_cast<std::int32_t>(maps_.size()));
  found_.resize(static_cast<std::size_t>((mesh.cell_count() + chunk_size - 1) / chunk_size));
}

inline void StrainGauge::find_slopes(const Vector& displacement, std::ptrdiff_t cell, Slopes& slopes) const {
  const std::int32_t* nodes = mesh_.cells.row(cell).data();
  const auto at = [&](int a) { return displacement.segment<3>(3 * static_cast<std::ptrdiff_t>(nodes[a])); };
  if (points_ == 1) {
    for (int k = 0; k < 3; ++k) slopes.col(k) = at(k + 1) - at(0);
    return;
  }
  Nodes u;
  for (int a = 0; a < 10; ++a) u.col(a) = at(a);
  slopes = slopes_at_points(u);
}

inline StrainGauge::CellMaps StrainGauge::maps_of(std::ptrdiff_t cell) const {
  const std::int32_t* first = &first_[static_cast<std::size_t>(cell)];
  return {&maps_[static_cast<std::size_t>(first[0])], first[1] - first[0] == 1};
}

Vector StrainGauge::at_points(const Vector& displacement) const {
  require_size("StrainGauge", "displacement", displacement.size(), 3 * mesh_.node_count());
  if (!displacement.allFinite())
    throw InvalidInput("StrainGauge: displacement is not finite; must be finite. Did the time step diverge?");
  Vector strain(points_ * mesh_.cell_count());
  for_chunks(mesh_.cell_count(), chunk_size, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    Slopes d;
    for (std::ptrdiff_t c = begin; c < end; ++c) {
      find_slopes(displacement, c, d);
      const CellMaps maps = maps_of(c);
      for (int p = 0; p < points_; ++p) {
        const Matrix3 H = d.middleCols<3>(3 * p) * maps[p].inverse;
        strain[points_ * c + p] = spectral_norm(strain_of(H, measure_));
      }
    }
  });
  return strain;
}

Vector StrainGauge::volumes() const {
  Vector volume(points_ * mesh_.cell_count());
  for (std::ptrdiff_t c = 0; c < mesh_.cell_count(); ++c)
    for (int p = 0; p < points_; ++p) volume[points_ * c + p] = maps_of(c)[p].volume;
  return volume;
}

void StrainGauge::read(const Vector& displacement, std::ptrdiff_t begin, std::ptrdiff_t end, Found& found) const {
  found.strain.clear();
  found.gradient.clear();
  found.suspects.clear();
  const double strain_cut = below(cuts_.strain), gradient_cut = below(cuts_.gradient);
  Slopes d;
  double sum = 0.0;
  for (std::ptrdiff_t c = begin; c < end; ++c) {
    find_slopes(displacement, c, d);
    const CellMaps maps = maps_of(c);
    double steepest = 0.0;
    for (int p = 0; p < points_; ++p) {
      const Map& at = maps[p];
      const Matrix3 H = d.middleCols<3>(3 * p) * at.inverse;
      // Frobenius' norm bounds the spectral one, and costs little: most points end here.
      const double gradient = H.squaredNorm();
      const double strain = measure_ == StrainMeasure::small ? squared_norm_of_small_strain(H)
                                                             : strain_of(H, measure_).squaredNorm();
      steepest = std::max(steepest, gradient);
      sum += gradient;
      const auto keep = [&](std::vector<Reading>& readings, double value, double cut) {
        if (value >= cut) readings.push_back({value, at.volume, static_cast<std::int32_t>(points_ * c + p)});
      };
      if (strain >= strain_cut) keep(found.strain, spectral_norm(strain_of(H, measure_)), cuts_.strain);
      if (gradient >= gradient_cut) keep(found.gradient, norm(H), cuts_.gradient);
    }
    const double growth = growth_[static_cast<std::size_t>(c)];
    if (!(growth * growth * steepest < 0.99)) found.suspects.push_back(static_cast<std::int32_t>(c));
  }
  found.finite = std::isfinite(sum);
}

Strains StrainGauge::measure(const Vector& displacement) {
  require_size("StrainGauge", "displacement", displacement.size(), 3 * mesh_.node_count());
  for (;;) {
    for_chunks(mesh_.cell_count(), chunk_size,
               [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t chunk) {
                 read(displacement, begin, end, found_[static_cast<std::size_t>(chunk)]);
               });
    strain_.clear();
    gradient_.clear();
    suspects_.clear();
    for (const Found& found : found_) {
      if (!found.finite)
        throw InvalidInput("StrainGauge: displacement is not finite; must be finite. Did the time step diverge?");
      strain_.insert(strain_.end(), found.strain.begin(), found.strain.end());
      gradient_.insert(gradient_.end(), found.gradient.begin(), found.gradient.end());
      suspects_.insert(suspects_.end(), found.suspects.begin(), found.suspects.end());
    }
    const auto strain = percentile(strain_, beyond * volume_), gradient = percentile(gradient_, beyond * volume_);
    // Where too little reaches a cut, strains have fallen by more than it was lowered.
    cuts_.strain = strain ? lowered * *strain : next_lower(cuts_.strain);
    cuts_.gradient = gradient ? lowered * *gradient : next_lower(cuts_.gradient);
    if (!strain || !gradient) continue;
    Strains strains;
    strains.strain = *strain;
    strains.neglected = 0.5 * *gradient * *gradient;
    strains.largest = strain_.front().value;
    strains.cell = strain_.front().point / points_;
    strains.place = place(strain_.front().point);
    return strains;
  }
}

/// Of a point in the reference shape, m.
Vector3 StrainGauge::place(std::int32_t point) const {
  const std::int32_t* cell = mesh_.cells.row(point / points_).data();
  Vector3 x = Vector3::Zero();
  if (points_ == 1) {
    for (int a = 0; a < 4; ++a) x += 0.25 * mesh_.points.row(cell[a]).transpose();
    return x;
  }
  const auto& rule = tetrahedron_rule_degree_2();
  const ShapeValues N = quadratic_shapes(rule[static_cast<std::size_t>(point % points_)].at);
  for (int a = 0; a < 10; ++a) x += N[a] * mesh_.points.row(cell[a]).transpose();
  return x;
}

}  // namespace plica

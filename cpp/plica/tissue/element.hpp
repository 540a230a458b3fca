#pragma once
// Shape functions, quadrature and the integrals of one tetrahedron.
#include <array>
#include <vector>

#include "plica/core/types.hpp"
#include "plica/tissue/material.hpp"

namespace plica {

/// A point in barycentric coordinates and its share of the volume (4) or the area (3); shares sum to 1.
template <int Corners>
struct QuadraturePoint {
  std::array<double, Corners> at;
  double weight;
};
using TetrahedronRule = std::vector<QuadraturePoint<4>>;
using TriangleRule = std::vector<QuadraturePoint<3>>;

/// Rules with positive weights and inner points, exact for polynomials up to the degree in their name.
const TetrahedronRule& tetrahedron_rule_degree_2();  // 4 points
const TetrahedronRule& tetrahedron_rule_degree_5();  // 15 points
const TriangleRule& triangle_rule_degree_5();        // 7 points

using ShapeValues = Eigen::Matrix<double, 10, 1>;
using ShapeSlopes = Eigen::Matrix<double, 10, 4>;
/// Quadratic shape functions, VTK order: corners l_i (2 l_i - 1), mid-sides 4 l_i l_j.
ShapeValues quadratic_shapes(const std::array<double, 4>& at);
/// (10, 4) their derivatives with respect to the four barycentric coordinates.
ShapeSlopes quadratic_slopes(const std::array<double, 4>& at);
/// Values on a six-node triangle, VTK order.
Eigen::Matrix<double, 6, 1> triangle_shapes(const std::array<double, 3>& at);
/// (6, 3) their derivatives with respect to the three barycentric coordinates.
Eigen::Matrix<double, 6, 3> triangle_slopes(const std::array<double, 3>& at);

/// One tetrahedron at its place; linear, quadratic with straight sides (both in closed form), or
/// quadratic and curved (isoparametric, 15 points).
class Element {
 public:
  explicit Element(int order);
  int nodes() const { return order_ == 2 ? 10 : 4; }

  /// Takes over the geometry of a cell; `cell` points to its node numbers. Sides count as straight
  /// if their middles are off by less than 1e-10 of their length.
  void place(const Points& points, const std::int32_t* cell);

  bool curved() const { return curved_; }
  double volume() const { return volume_; }  // m^3, negative where inverted
  /// Least det(dx/dxi) / 6 (m^3) over the quadrature points: the volume unless curved.
  double least_jacobian() const;

  /// out (nodes): int N_a dV, m^3.
  void load(double* out) const;
  /// out (nodes, nodes): int N_a N_b dV, m^3.
  void mass(double* out) const;
  /// out (nodes): what of its mass lies at each node, kg; row sums for linear, diagonal scaling (HRZ) for
  /// quadratic tetrahedra. density: kg/m^3.
  void lumped_mass(double density, double* out) const;
  /// out (nodes, nodes) blocks (3, 3), row-major: int B_a^T D B_b dV, N/m; written for b >= a only.
  /// D (6, 6) symmetric, Pa.
  void stiffness(const Matrix6& D, double* out) const;
  /// (nodes, 3) 1/m: dN/dx at a point.
  Eigen::Matrix<double, Eigen::Dynamic, 3> gradients(const std::array<double, 4>& at) const;
  /// m^3, det(dx/dxi) / 6 at a point: the volume unless curved.
  double measure(const std::array<double, 4>& at) const;
  /// (nodes, 3) 1/m: dN/dx at the centroid.
  Eigen::Matrix<double, Eigen::Dynamic, 3> centroid_gradients() const;

 private:
  struct Point {
    Eigen::Matrix<double, 10, 3, Eigen::RowMajor> gradients;
    double weight;  // m^3
  };
  Point evaluate(const ShapeSlopes& slopes, double share) const;

  int order_;
  bool curved_ = false;
  double volume_ = 0;
  Eigen::Matrix<double, 10, 3, Eigen::RowMajor> x_;         // nodes, m
  Eigen::Matrix<double, 4, 3, Eigen::RowMajor> gradients_;  // of the barycentric coordinates; straight sides
  std::vector<Point> points_;                               // curved only
};

/// Adds blocks as written by Element::stiffness to `values` (9 an entry), the lower half by transposition;
/// entries (nodes, nodes) holds the number of the block in `values`.
void add_symmetric_blocks(const double* blocks, int nodes, const std::int32_t* entries, double* values);

}  // namespace plica

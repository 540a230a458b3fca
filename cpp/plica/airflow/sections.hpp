#pragma once
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

/// A point that moves with the tissue: a fixed combination of at most six nodes.
struct MaterialPoint {
  std::vector<std::int32_t> nodes;
  std::vector<double> weights;
  Vector3 at(const Points& x) const;
};

/// The horizontal sections of the glottis. Section i is carried by two material points where the reference
/// interface crosses the mid-coronal plane y = 0 at height z_i, one on each fold; where no node lies at
/// y = 0 the interface is cut there.
struct Sections {
  Vector height;                     // (s) m, reference z, ascending
  Vector major;                      // (s) m, half the anteroposterior extent of the airway at that height
  std::vector<MaterialPoint> right;  // (s) x > 0
  std::vector<MaterialPoint> left;   // (s) x < 0

  std::ptrdiff_t count() const { return height.size(); }
  /// Signed half-widths (s, 2) m: x of the right point, -x of the left point.
  Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor> half_widths(const Points& x) const;
};

/// Sections at every height where the right or left mid-coronal line of `surface` has a vertex (heights closer
/// than 1e-6 of the extent are one) and both lines exist. Throws InvalidInput where the surface does not cross
/// y = 0 on both sides, or has several x at one height there.
Sections coronal_sections(const TetMesh& mesh, const Faces& surface);

/// Area enclosed by the interface at positions x in the plane z = height (m^2), from its cut polygon;
/// counts overlap of the folds as negative; nodes in the plane are allowed. O(faces).
double cut_area(const Points& x, const Triangles& surface, double height);

/// The same for many planes at ascending heights (s), in one pass: O(faces + cuts).
Vector cut_areas(const Points& x, const Triangles& surface, const Vector& heights);

}  // namespace plica

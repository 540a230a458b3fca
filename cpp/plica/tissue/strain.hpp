#pragma once
#include <vector>

#include "plica/mesh/tet_mesh.hpp"

namespace plica {

/// How large the strains of a displacement are, and what linear tissue leaves out of them. A percentile is one by
/// volume: the tissue beyond it is `StrainGauge::beyond` of the whole.
struct Strains {
  double strain = 0.0;  // -, 99.9th percentile of |eps| (StrainMeasure), the largest principal strain's magnitude
  double neglected = 0.0;  // -, 99.9th percentile of |E - eps| = |grad u|^2 / 2, E Green and Lagrange's strain
  double largest = 0.0;    // -, |eps| where it is largest
  std::int32_t cell = 0;   // of that, the lowest where there are several
  Vector3 place = Vector3::Zero();  // m, of its point in the reference shape
};

/// Which strain: eps of linear tissue, or Green and Lagrange's E = eps + (grad u)^T grad u / 2.
enum class StrainMeasure { small, green };

/// Reads strains off a displacement: in a linear tetrahedron its one strain, in a quadratic one those at the four
/// points of the quadrature rule of degree 2, each of which stands for its share of the volume. All norms are
/// spectral (docs/theory/tissue.md, "Large strains").
class StrainGauge {
 public:
  static constexpr double beyond = 1e-3;  // of the volume lies beyond a percentile

  /// Keeps the inverse Jacobians: 80 bytes a cell, 320 where it is curved. The mesh must outlive it. O(cells).
  explicit StrainGauge(const TetMesh& mesh, StrainMeasure measure = StrainMeasure::small);

  /// displacement (3 n) m. The same for any number of threads and whatever was measured before. O(cells).
  /// Throws InvalidInput where a displacement is not finite.
  Strains measure(const Vector& displacement);
  /// (4 m), of linear cells (m): |eps| at each point, that at point k of cell c in row 4 c + k. Throws as measure.
  Vector at_points(const Vector& displacement) const;
  /// (4 m) or (m) m^3: what each point stands for.
  Vector volumes() const;
  /// Cells that may be folded over (folded_cells) under the displacement last measured, ascending; no other is:
  /// where |grad u| < 1, det(I + grad u) > 0.
  const std::vector<std::int32_t>& suspects() const { return suspects_; }

 private:
  using Slopes = Eigen::Matrix<double, 3, 12>;  // d/dxi_k at each point, side by side; xi_k = l_k, k = 1, 2, 3
  struct Map {
    Matrix3 inverse;  // 1/m, dxi/dx
    double volume;    // m^3, that a point with this map stands for
  };
  struct Reading {
    double value;
    double volume;       // m^3
    std::int32_t point;  // 4 cell + k
  };
  /// Readings that may reach the cut, of one chunk of cells.
  struct Found {
    std::vector<Reading> strain, gradient;
    std::vector<std::int32_t> suspects;
    bool finite = true;
  };
  /// The percentiles are looked for among readings from a cut on, set by those of the last measurement.
  struct Cuts {
    double strain = 0.0, gradient = 0.0;
  };
  /// Of the points of a cell.
  struct CellMaps {
    const Map* first;
    bool one;  // for all points
    const Map& operator[](int point) const { return first[one ? 0 : point]; }
  };
  CellMaps maps_of(std::ptrdiff_t cell) const;
  /// To du/dxi at the points of a cell.
  void find_slopes(const Vector& displacement, std::ptrdiff_t cell, Slopes& slopes) const;
  void read(const Vector& displacement, std::ptrdiff_t begin, std::ptrdiff_t end, Found& found) const;
  Vector3 place(std::int32_t point) const;

  const TetMesh& mesh_;
  StrainMeasure measure_;
  int points_;                       // of a cell
  std::vector<Map> maps_;            // one a cell, or one a point where it is curved
  std::vector<std::int32_t> first_;  // (m + 1) maps of each cell
  std::vector<double> growth_;       // (m) |grad u| at a node is at most so many times the largest at the points
  double volume_ = 0.0;              // m^3
  Cuts cuts_;
  std::vector<Found> found_;                // one a chunk
  std::vector<Reading> strain_, gradient_;  // of all
  std::vector<std::int32_t> suspects_;
};

}  // namespace plica

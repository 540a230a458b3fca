#pragma once
#include <Eigen/SparseCore>
#include <memory>

#include "plica/core/types.hpp"

namespace plica {

/// Which nodes couple: compressed rows over nodes, columns ascending, the diagonal present in every row.
struct NodePattern {
  std::vector<std::int32_t> row_start;  // (n + 1)
  std::vector<std::int32_t> column;     // (entries)

  std::ptrdiff_t rows() const { return static_cast<std::ptrdiff_t>(row_start.size()) - 1; }
  std::ptrdiff_t entries() const { return static_cast<std::ptrdiff_t>(column.size()); }
  /// Position of (row, col) in `column`, or -1. O(log row length).
  std::int32_t find(std::int32_t row, std::int32_t col) const;
};

using Pattern = std::shared_ptr<const NodePattern>;
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor, std::int32_t>;

/// Sparse matrix of 3x3 blocks (stiffness, viscosity, step matrix); blocks row-major, 72 bytes each.
class BlockMatrix {
 public:
  explicit BlockMatrix(Pattern pattern);

  const Pattern& pattern() const { return pattern_; }
  std::ptrdiff_t rows() const { return 3 * pattern_->rows(); }
  double* block(std::ptrdiff_t entry) { return values_.data() + 9 * entry; }
  const double* block(std::ptrdiff_t entry) const { return values_.data() + 9 * entry; }
  std::vector<double>& values() { return values_; }
  const std::vector<double>& values() const { return values_; }

  /// y = A x; x, y (3 n), not the same vector. Threaded over rows. Floor: 76 bytes an entry.
  void multiply(const Vector& x, Vector& y) const;
  Vector operator*(const Vector& x) const;
  /// The node rows [begin, end) of y = A x alone, for loops that do more to those rows; x, y (3 n).
  void multiply_rows(std::ptrdiff_t begin, std::ptrdiff_t end, const Vector& x, Vector& y) const;
  /// The same for `pack` vectors at once, x[pack * unknown + vector]; every vector takes the same arithmetic.
  void multiply_rows_packed(std::ptrdiff_t begin, std::ptrdiff_t end, const std::vector<double>& x,
                            std::vector<double>& y) const;
  static constexpr int pack = 8;
  /// Node rows that one chunk of a threaded loop takes.
  static constexpr std::ptrdiff_t chunk_rows = 256;
  /// The same matrix in compressed scalar rows (3 n, 3 n), for readers and factorisations.
  SparseMatrix to_sparse() const;

 private:
  Pattern pattern_;
  std::vector<double> values_;
};

/// Sparse matrix m (x) I3, one number per pair of nodes (the mass matrix).
class NodalMatrix {
 public:
  explicit NodalMatrix(Pattern pattern);

  const Pattern& pattern() const { return pattern_; }
  std::ptrdiff_t rows() const { return 3 * pattern_->rows(); }
  std::vector<double>& values() { return values_; }
  const std::vector<double>& values() const { return values_; }

  void multiply(const Vector& x, Vector& y) const;
  Vector operator*(const Vector& x) const;
  SparseMatrix to_sparse() const;

 private:
  Pattern pattern_;
  std::vector<double> values_;
};

}  // namespace plica

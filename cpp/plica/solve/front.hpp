#pragma once
#include <cstddef>
#include <vector>

namespace plica {

/// A dense symmetric matrix, lower triangle in columns, whose first columns are eliminated.
struct Front {
  explicit Front(std::ptrdiff_t rows) : size(rows), values(static_cast<std::size_t>(rows * rows), 0.0) {}
  double* column(std::ptrdiff_t j) { return values.data() + j * size; }
  double& at(std::ptrdiff_t i, std::ptrdiff_t j) { return values[static_cast<std::size_t>(j * size + i)]; }

  /// Replaces the first `pivots` columns by those of the Cholesky factor and the rest by the Schur complement
  /// (lower triangles; what lies above is arbitrary). Returns the first column whose pivot is not above `least`,
  /// or -1.
  std::ptrdiff_t eliminate(std::ptrdiff_t pivots, double least);

  std::ptrdiff_t size;
  std::vector<double> values;
};

}  // namespace plica

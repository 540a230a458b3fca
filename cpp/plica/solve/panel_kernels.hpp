#pragma once
#include <cstddef>

namespace plica {

/// The inner loops of a factor in tiles of 8 x 8 floats, column by column. A panel is a run of column groups of 8;
/// a group is a tile with the inverse of its triangle and a tile for each 8 rows below.
struct PanelKernels {
  /// f (8 * tiles) of a panel of `groups` column groups, `tiles` tiles high at the first: L y = f in its columns,
  /// f - L y in the rows below.
  void (*forward)(const float* panel, std::ptrdiff_t groups, std::ptrdiff_t tiles, float* f);
  /// Solves L^T x = f - (L below)^T f below in the columns.
  void (*backward)(const float* panel, std::ptrdiff_t groups, std::ptrdiff_t tiles, float* f);
  /// The same for 8 vectors at once, f[8 * row + vector]; every vector takes the same arithmetic.
  void (*forward_packed)(const float* panel, std::ptrdiff_t groups, std::ptrdiff_t tiles, float* f);
  void (*backward_packed)(const float* panel, std::ptrdiff_t groups, std::ptrdiff_t tiles, float* f);
  /// The same for 16 vectors at once, f[16 * row + vector].
  void (*forward_wide)(const float* panel, std::ptrdiff_t groups, std::ptrdiff_t tiles, float* f);
  void (*backward_wide)(const float* panel, std::ptrdiff_t groups, std::ptrdiff_t tiles, float* f);
  /// c[j][i] = sum_k a[8 k + i] b[4 k + j] for the 8 x 4 block of a product of packed strips.
  void (*strip_product)(const double* a, const double* b, std::ptrdiff_t count, double* c);
  /// y -= sum of four columns times a factor each: y[i] -= sum_k a[k] x[k][i].
  void (*subtract_columns)(const double* const* x, const double* a, double* y, std::ptrdiff_t count);
};

/// In the version for the processor at hand, as in core/block_product.hpp.
const PanelKernels& panel_kernels();

}  // namespace plica

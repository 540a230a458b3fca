#pragma once
#include <cstddef>

namespace plica::estimation {

/// The inner loops of dense products and triangular solves, in the version for the processor at hand.
struct ProductKernels {
  int rows, columns;  // of the tile of a product
  int strip;          // columns that one triangular solve takes at once

  /// c[i * stride + j] = (or +=, if `add`) scale * sum_k a[rows * k + i] b[columns * k + j]; a and b are packed.
  using Tile = void (*)(const double* a, const double* b, std::ptrdiff_t depth, double scale, double* c,
                        std::ptrdiff_t stride, bool add);
  Tile tile[2][2];  // [of all rows, of the first half][of all columns, of the first half]
  /// R^T X = X in place: R (n, n) upper, row-major with `stride`; x (n, strip), packed.
  void (*forward)(const double* r, std::ptrdiff_t stride, std::ptrdiff_t n, double* x);
  /// R X = X in place.
  void (*backward)(const double* r, std::ptrdiff_t stride, std::ptrdiff_t n, double* x);
  /// A = R^T R in place of the upper triangle of A (n, n). The first row whose pivot is not positive, or n.
  std::ptrdiff_t (*cholesky)(double* a, std::ptrdiff_t stride, std::ptrdiff_t n);
};

const ProductKernels& product_kernels();

}  // namespace plica::estimation

#include "plica/core/block_product.hpp"

#include "plica/core/block_matrix.hpp"
#include "plica/core/versions.hpp"

namespace plica {
namespace {

/// Nine running sums a row, one per block entry, so that no sum waits for the one before.
template <typename Real>
PLICA_INLINE void block_rows(const std::int32_t* row_start, const std::int32_t* column, const Real* values,
                             const double* x, double* y, std::ptrdiff_t begin, std::ptrdiff_t end) {
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    double s00 = 0, s01 = 0, s02 = 0, s10 = 0, s11 = 0, s12 = 0, s20 = 0, s21 = 0, s22 = 0;
    for (std::ptrdiff_t e = row_start[i]; e < row_start[i + 1]; ++e) {
      const Real* b = values + 9 * e;
      const double* xj = x + 3 * static_cast<std::ptrdiff_t>(column[e]);
      const double x0 = xj[0], x1 = xj[1], x2 = xj[2];
      s00 += b[0] * x0;
      s01 += b[1] * x1;
      s02 += b[2] * x2;
      s10 += b[3] * x0;
      s11 += b[4] * x1;
      s12 += b[5] * x2;
      s20 += b[6] * x0;
      s21 += b[7] * x1;
      s22 += b[8] * x2;
    }
    y[3 * i] = s00 + s01 + s02;
    y[3 * i + 1] = s10 + s11 + s12;
    y[3 * i + 2] = s20 + s21 + s22;
  }
}

PLICA_INLINE void packed_rows(const std::int32_t* row_start, const std::int32_t* column, const double* values,
                              const double* x, double* y, std::ptrdiff_t begin, std::ptrdiff_t end) {
  constexpr int w = BlockMatrix::pack;
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    double s0[w] = {}, s1[w] = {}, s2[w] = {};
    for (std::ptrdiff_t e = row_start[i]; e < row_start[i + 1]; ++e) {
      const double* b = values + 9 * e;
      const double* xj = x + 3 * w * static_cast<std::ptrdiff_t>(column[e]);
      for (int v = 0; v < w; ++v) {
        const double x0 = xj[v], x1 = xj[w + v], x2 = xj[2 * w + v];
        s0[v] += b[0] * x0 + b[1] * x1 + b[2] * x2;
        s1[v] += b[3] * x0 + b[4] * x1 + b[5] * x2;
        s2[v] += b[6] * x0 + b[7] * x1 + b[8] * x2;
      }
    }
    double* yi = y + 3 * w * i;
    for (int v = 0; v < w; ++v) yi[v] = s0[v];
    for (int v = 0; v < w; ++v) yi[w + v] = s1[v];
    for (int v = 0; v < w; ++v) yi[2 * w + v] = s2[v];
  }
}

PLICA_INLINE void nodal_rows(const std::int32_t* row_start, const std::int32_t* column, const double* values,
                             const double* x, double* y, std::ptrdiff_t begin, std::ptrdiff_t end) {
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    double s0 = 0, s1 = 0, s2 = 0;
    for (std::ptrdiff_t e = row_start[i]; e < row_start[i + 1]; ++e) {
      const double* xj = x + 3 * static_cast<std::ptrdiff_t>(column[e]);
      s0 += values[e] * xj[0];
      s1 += values[e] * xj[1];
      s2 += values[e] * xj[2];
    }
    y[3 * i] = s0;
    y[3 * i + 1] = s1;
    y[3 * i + 2] = s2;
  }
}

#define PLICA_ROW_PRODUCT(name, body, Real, target)                                               \
  target void name(const std::int32_t* row_start, const std::int32_t* column, const Real* values, \
                   const double* x, double* y, std::ptrdiff_t begin, std::ptrdiff_t end) {        \
    body(row_start, column, values, x, y, begin, end);                                            \
  }
#define PLICA_ROW_PRODUCTS(suffix, target)                        \
  PLICA_ROW_PRODUCT(blocks_##suffix, block_rows, double, target)  \
  PLICA_ROW_PRODUCT(packed_##suffix, packed_rows, double, target) \
  PLICA_ROW_PRODUCT(nodal_##suffix, nodal_rows, double, target)   \
  PLICA_ROW_PRODUCT(single_##suffix, block_rows, float, target)   \
  constexpr RowProducts products_##suffix{blocks_##suffix, packed_##suffix, nodal_##suffix, single_##suffix};
PLICA_ROW_PRODUCTS(any, )
PLICA_ROW_PRODUCTS(fused, PLICA_FUSED)
#undef PLICA_ROW_PRODUCTS
#undef PLICA_ROW_PRODUCT

}  // namespace

const RowProducts& row_products() {
  static const RowProducts& chosen = takes_fused() ? products_fused : products_any;
  return chosen;
}

}  // namespace plica

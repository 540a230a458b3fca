#include "plica/estimation/product_kernels.hpp"

#include <cmath>

#include "plica/core/registers.hpp"
#include "plica/core/versions.hpp"

namespace plica::estimation {
namespace {

/// R rows of C registers are the running sums: as many as the processor has, less those of b and of a. An edge
/// takes the first `rows` and `registers` of them.
template <typename Width, int R, int C, int rows, int registers>
PLICA_INLINE void tile_body(const double* a, const double* b, std::ptrdiff_t depth, double scale, double* c,
                            std::ptrdiff_t stride, bool add) {
  typedef typename Width::Register Register;
  constexpr int w = sizeof(Register) / sizeof(double);
  Register sum[rows][registers] = {};
  for (std::ptrdiff_t k = 0; k < depth; ++k) {
    Register row[registers];
#pragma GCC unroll 4
    for (int j = 0; j < registers; ++j) row[j] = *reinterpret_cast<const Register*>(b + w * j);
#pragma GCC unroll 16
    for (int i = 0; i < rows; ++i) {
#pragma GCC unroll 4
      for (int j = 0; j < registers; ++j) sum[i][j] += row[j] * a[i];
    }
    a += R;
    b += w * C;
  }
#pragma GCC unroll 16
  for (int i = 0; i < rows; ++i) {
#pragma GCC unroll 4
    for (int j = 0; j < registers; ++j) {
      Register* out = reinterpret_cast<Register*>(c + i * stride + w * j);
      *out = add ? *out + sum[i][j] * scale : sum[i][j] * scale;
    }
  }
}

/// Eight registers of x are solved at once, so that no product waits for the one before.
constexpr int at_once = 8;

template <typename Width>
PLICA_INLINE void forward_body(const double* r, std::ptrdiff_t stride, std::ptrdiff_t n, double* x) {
  typedef typename Width::Register Register;
  Register* rows = reinterpret_cast<Register*>(x);
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    Register sum[at_once];
#pragma GCC unroll 8
    for (int j = 0; j < at_once; ++j) sum[j] = rows[at_once * i + j];
    for (std::ptrdiff_t k = 0; k < i; ++k) {
      const double factor = r[k * stride + i];
#pragma GCC unroll 8
      for (int j = 0; j < at_once; ++j) sum[j] -= rows[at_once * k + j] * factor;
    }
    const double inverse = 1.0 / r[i * stride + i];
#pragma GCC unroll 8
    for (int j = 0; j < at_once; ++j) rows[at_once * i + j] = sum[j] * inverse;
  }
}

template <typename Width>
PLICA_INLINE void backward_body(const double* r, std::ptrdiff_t stride, std::ptrdiff_t n, double* x) {
  typedef typename Width::Register Register;
  Register* rows = reinterpret_cast<Register*>(x);
  for (std::ptrdiff_t i = n - 1; i >= 0; --i) {
    Register sum[at_once];
#pragma GCC unroll 8
    for (int j = 0; j < at_once; ++j) sum[j] = rows[at_once * i + j];
    for (std::ptrdiff_t k = i + 1; k < n; ++k) {
      const double factor = r[i * stride + k];
#pragma GCC unroll 8
      for (int j = 0; j < at_once; ++j) sum[j] -= rows[at_once * k + j] * factor;
    }
    const double inverse = 1.0 / r[i * stride + i];
#pragma GCC unroll 8
    for (int j = 0; j < at_once; ++j) rows[at_once * i + j] = sum[j] * inverse;
  }
}

PLICA_INLINE std::ptrdiff_t cholesky_body(double* a, std::ptrdiff_t stride, std::ptrdiff_t n) {
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    double* pivot = a + k * stride;
    if (!(pivot[k] > 0.0)) return k;
    const double root = std::sqrt(pivot[k]), inverse = 1.0 / root;
    pivot[k] = root;
    for (std::ptrdiff_t j = k + 1; j < n; ++j) pivot[j] *= inverse;
    for (std::ptrdiff_t i = k + 1; i < n; ++i) {
      double* row = a + i * stride;
      const double factor = pivot[i];
      for (std::ptrdiff_t j = i; j < n; ++j) row[j] -= factor * pivot[j];
    }
  }
  return n;
}

// A version is the same bodies compiled for other instructions; __VA_ARGS__ is its target attribute.
#define PLICA_TILE(name, Width, R, C, rows, registers, ...)                                              \
  __VA_ARGS__ void name(const double* a, const double* b, std::ptrdiff_t depth, double scale, double* c, \
                        std::ptrdiff_t stride, bool add) {                                               \
    tile_body<Width, R, C, rows, registers>(a, b, depth, scale, c, stride, add);                         \
  }
#define PLICA_VERSION(suffix, Width, R, C, ...)                                                                   \
  PLICA_TILE(tile_##suffix, Width, R, C, R, C, __VA_ARGS__)                                                       \
  PLICA_TILE(low_##suffix, Width, R, C, R / 2, C, __VA_ARGS__)                                                    \
  PLICA_TILE(narrow_##suffix, Width, R, C, R, C / 2, __VA_ARGS__)                                                 \
  PLICA_TILE(small_##suffix, Width, R, C, R / 2, C / 2, __VA_ARGS__)                                              \
  __VA_ARGS__ void forward_##suffix(const double* r, std::ptrdiff_t stride, std::ptrdiff_t n, double* x) {        \
    forward_body<Width>(r, stride, n, x);                                                                         \
  }                                                                                                               \
  __VA_ARGS__ void backward_##suffix(const double* r, std::ptrdiff_t stride, std::ptrdiff_t n, double* x) {       \
    backward_body<Width>(r, stride, n, x);                                                                        \
  }                                                                                                               \
  __VA_ARGS__ std::ptrdiff_t cholesky_##suffix(double* a, std::ptrdiff_t stride, std::ptrdiff_t n) {              \
    return cholesky_body(a, stride, n);                                                                           \
  }                                                                                                               \
  constexpr ProductKernels kernels_##suffix{R,                                                                    \
                                            C * static_cast<int>(sizeof(Width::Register) / sizeof(double)),       \
                                            at_once * static_cast<int>(sizeof(Width::Register) / sizeof(double)), \
                                            {{tile_##suffix, narrow_##suffix}, {low_##suffix, small_##suffix}},   \
                                            forward_##suffix,                                                     \
                                            backward_##suffix,                                                    \
                                            cholesky_##suffix};
PLICA_VERSION(any, TwoDoubles, 4, 2, )
PLICA_VERSION(fused, FourDoubles, 6, 2, PLICA_FUSED)
PLICA_VERSION(largest, EightDoubles, 12, 2, PLICA_LARGEST)
#undef PLICA_VERSION
#undef PLICA_TILE

}  // namespace

const ProductKernels& product_kernels() {
  static const ProductKernels& chosen = takes_largest() ? kernels_largest
                                        : takes_fused() ? kernels_fused
                                                        : kernels_any;
  return chosen;
}

}  // namespace plica::estimation

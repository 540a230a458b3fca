#include "plica/solve/panel_kernels.hpp"

#include "plica/core/versions.hpp"

namespace plica {
namespace {

constexpr int w = 8;

/// Eight floats: a register where the processor has such wide ones, otherwise the compiler divides it. Vectors are
/// GCC's and Clang's.
#if defined(__GNUC__)
typedef float Floats __attribute__((vector_size(4 * w), aligned(4), may_alias));
typedef double Doubles __attribute__((vector_size(32), aligned(8), may_alias));
#else
#error "plica: panel_kernels.cpp needs the vector types of GCC or Clang"
#endif

PLICA_INLINE void forward_body(const float* panel, std::ptrdiff_t groups, std::ptrdiff_t tiles, float* f) {
  for (std::ptrdiff_t g = 0; g < groups; ++g) {
    const Floats* t = reinterpret_cast<const Floats*>(panel);
    float* top = f + w * g;
    Floats even = t[0] * top[0], odd = t[1] * top[1];
    for (int j = 2; j < w; j += 2) even += t[j] * top[j], odd += t[j + 1] * top[j + 1];
    const Floats y = even + odd;
    *reinterpret_cast<Floats*>(top) = y;
    const Floats zero = {};
    const Floats y0 = zero + y[0], y1 = zero + y[1], y2 = zero + y[2], y3 = zero + y[3], y4 = zero + y[4],
                 y5 = zero + y[5], y6 = zero + y[6], y7 = zero + y[7];
    for (std::ptrdiff_t k = g + 1; k < tiles; ++k) {
      t += w;
      Floats* row = reinterpret_cast<Floats*>(f + w * k);
      Floats a = t[0] * y0, b = t[1] * y1;
      a += t[2] * y2;
      b += t[3] * y3;
      a += t[4] * y4;
      b += t[5] * y5;
      a += t[6] * y6;
      b += t[7] * y7;
      *row -= a + b;
    }
    panel += w * w * (tiles - g);
  }
}

PLICA_INLINE float sum(const Floats& v) {
  return ((v[0] + v[4]) + (v[1] + v[5])) + ((v[2] + v[6]) + (v[3] + v[7]));
}

PLICA_INLINE void backward_body(const float* panel, std::ptrdiff_t groups, std::ptrdiff_t tiles, float* f) {
  panel += w * w * (groups * tiles - groups * (groups - 1) / 2);
  for (std::ptrdiff_t g = groups - 1; g >= 0; --g) {
    panel -= w * w * (tiles - g);
    const Floats* t = reinterpret_cast<const Floats*>(panel);
    Floats s0 = {}, s1 = {}, s2 = {}, s3 = {}, s4 = {}, s5 = {}, s6 = {}, s7 = {};
    for (std::ptrdiff_t k = g + 1; k < tiles; ++k) {
      t += w;
      const Floats x = *reinterpret_cast<const Floats*>(f + w * k);
      s0 += t[0] * x;
      s1 += t[1] * x;
      s2 += t[2] * x;
      s3 += t[3] * x;
      s4 += t[4] * x;
      s5 += t[5] * x;
      s6 += t[6] * x;
      s7 += t[7] * x;
    }
    t = reinterpret_cast<const Floats*>(panel);
    float* top = f + w * g;
    const Floats rest = *reinterpret_cast<const Floats*>(top) -
                        Floats{sum(s0), sum(s1), sum(s2), sum(s3), sum(s4), sum(s5), sum(s6), sum(s7)};
    *reinterpret_cast<Floats*>(top) =
        Floats{sum(t[0] * rest), sum(t[1] * rest), sum(t[2] * rest), sum(t[3] * rest),
               sum(t[4] * rest), sum(t[5] * rest), sum(t[6] * rest), sum(t[7] * rest)};
  }
}

PLICA_INLINE void forward_packed_body(const float* panel, std::ptrdiff_t groups, std::ptrdiff_t tiles, float* f) {
  for (std::ptrdiff_t g = 0; g < groups; ++g) {
    Floats* top = reinterpret_cast<Floats*>(f + w * w * g);
    Floats y[w];
    for (int i = 0; i < w; ++i) {
      y[i] = panel[i] * top[0];
      for (int j = 1; j <= i; ++j) y[i] += panel[w * j + i] * top[j];
    }
    for (int i = 0; i < w; ++i) top[i] = y[i];
    for (std::ptrdiff_t k = g + 1; k < tiles; ++k) {
      panel += w * w;
      Floats* rows = reinterpret_cast<Floats*>(f + w * w * k);
      for (int i = 0; i < w; ++i) {
        Floats a = panel[i] * y[0], b = panel[w + i] * y[1];
        for (int j = 2; j < w; j += 2) a += panel[w * j + i] * y[j], b += panel[w * (j + 1) + i] * y[j + 1];
        rows[i] -= a + b;
      }
    }
    panel += w * w;
  }
}

PLICA_INLINE void backward_packed_body(const float* panel, std::ptrdiff_t groups, std::ptrdiff_t tiles, float* f) {
  panel += w * w * (groups * tiles - groups * (groups - 1) / 2);
  for (std::ptrdiff_t g = groups - 1; g >= 0; --g) {
    panel -= w * w * (tiles - g);
    const float* t = panel;
    Floats s[w] = {};
    for (std::ptrdiff_t k = g + 1; k < tiles; ++k) {
      t += w * w;
      const Floats* rows = reinterpret_cast<const Floats*>(f + w * w * k);
      for (int i = 0; i < w; ++i)
        for (int j = 0; j < w; ++j) s[j] += t[w * j + i] * rows[i];
    }
    Floats* top = reinterpret_cast<Floats*>(f + w * w * g);
    for (int j = 0; j < w; ++j) s[j] = top[j] - s[j];
    for (int j = 0; j < w; ++j) {
      Floats x = panel[w * j + j] * s[j];
      for (int i = j + 1; i < w; ++i) x += panel[w * j + i] * s[i];
      top[j] = x;
    }
  }
}

PLICA_INLINE void strip_body(const double* a, const double* b, std::ptrdiff_t count, double* c) {
  Doubles s00 = {}, s01 = {}, s10 = {}, s11 = {}, s20 = {}, s21 = {}, s30 = {}, s31 = {};
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    const Doubles low = *reinterpret_cast<const Doubles*>(a + 8 * k);
    const Doubles high = *reinterpret_cast<const Doubles*>(a + 8 * k + 4);
    s00 += low * b[4 * k];
    s01 += high * b[4 * k];
    s10 += low * b[4 * k + 1];
    s11 += high * b[4 * k + 1];
    s20 += low * b[4 * k + 2];
    s21 += high * b[4 * k + 2];
    s30 += low * b[4 * k + 3];
    s31 += high * b[4 * k + 3];
  }
  Doubles* out = reinterpret_cast<Doubles*>(c);
  out[0] = s00;
  out[1] = s01;
  out[2] = s10;
  out[3] = s11;
  out[4] = s20;
  out[5] = s21;
  out[6] = s30;
  out[7] = s31;
}

PLICA_INLINE void subtract_body(const double* const* x, const double* a, double* y, std::ptrdiff_t count) {
  const double *x0 = x[0], *x1 = x[1], *x2 = x[2], *x3 = x[3];
  for (std::ptrdiff_t i = 0; i < count; ++i) y[i] -= (a[0] * x0[i] + a[1] * x1[i]) + (a[2] * x2[i] + a[3] * x3[i]);
}

#define PLICA_PANEL_KERNELS(suffix, target)                                                                     \
  target void forward_##suffix(const float* p, std::ptrdiff_t g, std::ptrdiff_t t, float* f) {                  \
    forward_body(p, g, t, f);                                                                                   \
  }                                                                                                             \
  target void backward_##suffix(const float* p, std::ptrdiff_t g, std::ptrdiff_t t, float* f) {                 \
    backward_body(p, g, t, f);                                                                                  \
  }                                                                                                             \
  target void forward_packed_##suffix(const float* p, std::ptrdiff_t g, std::ptrdiff_t t, float* f) {           \
    forward_packed_body(p, g, t, f);                                                                            \
  }                                                                                                             \
  target void backward_packed_##suffix(const float* p, std::ptrdiff_t g, std::ptrdiff_t t, float* f) {          \
    backward_packed_body(p, g, t, f);                                                                           \
  }                                                                                                             \
  target void strip_##suffix(const double* a, const double* b, std::ptrdiff_t count, double* c) {               \
    strip_body(a, b, count, c);                                                                                 \
  }                                                                                                             \
  target void subtract_##suffix(const double* const* x, const double* a, double* y, std::ptrdiff_t count) {     \
    subtract_body(x, a, y, count);                                                                              \
  }                                                                                                             \
  constexpr PanelKernels kernels_##suffix{forward_##suffix,         backward_##suffix, forward_packed_##suffix, \
                                          backward_packed_##suffix, strip_##suffix,    subtract_##suffix};
PLICA_PANEL_KERNELS(any, )
PLICA_PANEL_KERNELS(fused, PLICA_FUSED)
#undef PLICA_PANEL_KERNELS

}  // namespace

const PanelKernels& panel_kernels() {
  static const PanelKernels& chosen = takes_fused() ? kernels_fused : kernels_any;
  return chosen;
}

}  // namespace plica

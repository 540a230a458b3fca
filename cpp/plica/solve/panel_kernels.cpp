#include "plica/solve/panel_kernels.hpp"

#include "plica/core/versions.hpp"

namespace plica {
namespace {

constexpr int w = 8;

/// Eight floats: a register where the processor has such wide ones, otherwise the compiler divides it. Vectors are
/// GCC's and Clang's.
#if defined(__GNUC__)
typedef float Floats __attribute__((vector_size(4 * w), aligned(4), may_alias));
// A template argument would lose the alignment of a vector type: it takes a struct that has the type.
struct EightLanes {
  typedef Floats Register;
};
struct SixteenLanes {
  typedef float Register __attribute__((vector_size(8 * w), aligned(4), may_alias));
};
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

/// `parts` registers side by side hold the vectors of a row; the panel's tiles stay in cache from part to part.
template <typename Width, int parts>
PLICA_INLINE void forward_packed_body(const float* panel, std::ptrdiff_t groups, std::ptrdiff_t tiles, float* f) {
  typedef typename Width::Register Register;
  constexpr int lanes = sizeof(Register) / sizeof(float);
  for (std::ptrdiff_t g = 0; g < groups; ++g) {
    for (int part = 0; part < parts; ++part) {
      const float* t = panel;
      Register* top = reinterpret_cast<Register*>(f + w * lanes * parts * g + lanes * part);
      Register y[w];
      for (int i = 0; i < w; ++i) {
        y[i] = t[i] * top[0];
        for (int j = 1; j <= i; ++j) y[i] += t[w * j + i] * top[parts * j];
      }
      for (int i = 0; i < w; ++i) top[parts * i] = y[i];
      for (std::ptrdiff_t k = g + 1; k < tiles; ++k) {
        t += w * w;
        Register* rows = reinterpret_cast<Register*>(f + w * lanes * parts * k + lanes * part);
        for (int i = 0; i < w; ++i) {
          Register a = t[i] * y[0], b = t[w + i] * y[1];
          for (int j = 2; j < w; j += 2) a += t[w * j + i] * y[j], b += t[w * (j + 1) + i] * y[j + 1];
          rows[parts * i] -= a + b;
        }
      }
    }
    panel += w * w * (tiles - g);
  }
}

template <typename Width, int parts>
PLICA_INLINE void backward_packed_body(const float* panel, std::ptrdiff_t groups, std::ptrdiff_t tiles, float* f) {
  typedef typename Width::Register Register;
  constexpr int lanes = sizeof(Register) / sizeof(float);
  panel += w * w * (groups * tiles - groups * (groups - 1) / 2);
  for (std::ptrdiff_t g = groups - 1; g >= 0; --g) {
    panel -= w * w * (tiles - g);
    for (int part = 0; part < parts; ++part) {
      const float* t = panel;
      Register s[w] = {};
      for (std::ptrdiff_t k = g + 1; k < tiles; ++k) {
        t += w * w;
        const Register* rows = reinterpret_cast<const Register*>(f + w * lanes * parts * k + lanes * part);
        for (int i = 0; i < w; ++i)
          for (int j = 0; j < w; ++j) s[j] += t[w * j + i] * rows[parts * i];
      }
      Register* top = reinterpret_cast<Register*>(f + w * lanes * parts * g + lanes * part);
      for (int j = 0; j < w; ++j) s[j] = top[parts * j] - s[j];
      for (int j = 0; j < w; ++j) {
        Register x = panel[w * j + j] * s[j];
        for (int i = j + 1; i < w; ++i) x += panel[w * j + i] * s[i];
        top[parts * j] = x;
      }
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

// What one vector takes, for the two versions there are of it.
#define PLICA_PANEL_KERNELS(suffix, target)                                                                 \
  target void forward_##suffix(const float* p, std::ptrdiff_t g, std::ptrdiff_t t, float* f) {              \
    forward_body(p, g, t, f);                                                                               \
  }                                                                                                         \
  target void backward_##suffix(const float* p, std::ptrdiff_t g, std::ptrdiff_t t, float* f) {             \
    backward_body(p, g, t, f);                                                                              \
  }                                                                                                         \
  target void forward_packed_##suffix(const float* p, std::ptrdiff_t g, std::ptrdiff_t t, float* f) {       \
    forward_packed_body<EightLanes, 1>(p, g, t, f);                                                         \
  }                                                                                                         \
  target void backward_packed_##suffix(const float* p, std::ptrdiff_t g, std::ptrdiff_t t, float* f) {      \
    backward_packed_body<EightLanes, 1>(p, g, t, f);                                                        \
  }                                                                                                         \
  target void strip_##suffix(const double* a, const double* b, std::ptrdiff_t count, double* c) {           \
    strip_body(a, b, count, c);                                                                             \
  }                                                                                                         \
  target void subtract_##suffix(const double* const* x, const double* a, double* y, std::ptrdiff_t count) { \
    subtract_body(x, a, y, count);                                                                          \
  }
// Sixteen vectors: two registers a row, or one of a processor with AVX-512.
#define PLICA_WIDE_PANELS(suffix, Width, parts, target)                                              \
  target void forward_wide_##suffix(const float* p, std::ptrdiff_t g, std::ptrdiff_t t, float* f) {  \
    forward_packed_body<Width, parts>(p, g, t, f);                                                   \
  }                                                                                                  \
  target void backward_wide_##suffix(const float* p, std::ptrdiff_t g, std::ptrdiff_t t, float* f) { \
    backward_packed_body<Width, parts>(p, g, t, f);                                                  \
  }
#define PLICA_PANEL_TABLE(name, suffix, wide)                                                         \
  constexpr PanelKernels name{forward_##suffix,         backward_##suffix,   forward_packed_##suffix, \
                              backward_packed_##suffix, forward_wide_##wide, backward_wide_##wide,    \
                              strip_##suffix,           subtract_##suffix};
PLICA_PANEL_KERNELS(any, )
PLICA_PANEL_KERNELS(fused, PLICA_FUSED)
PLICA_WIDE_PANELS(any, EightLanes, 2, )
PLICA_WIDE_PANELS(fused, EightLanes, 2, PLICA_FUSED)
PLICA_WIDE_PANELS(largest, SixteenLanes, 1, PLICA_LARGEST)
PLICA_PANEL_TABLE(kernels_any, any, any)
PLICA_PANEL_TABLE(kernels_fused, fused, fused)
PLICA_PANEL_TABLE(kernels_largest, fused, largest)
#undef PLICA_PANEL_TABLE
#undef PLICA_WIDE_PANELS
#undef PLICA_PANEL_KERNELS

}  // namespace

const PanelKernels& panel_kernels() {
  static const PanelKernels& chosen = takes_largest() ? kernels_largest
                                      : takes_fused() ? kernels_fused
                                                      : kernels_any;
  return chosen;
}

}  // namespace plica

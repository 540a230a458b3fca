#include "plica/imaging/median.hpp"

#include <vector>

#include "plica/core/threads.hpp"
#include "plica/core/versions.hpp"

namespace plica::imaging {
namespace {

PLICA_INLINE void order(float& a, float& b) {
  const float low = b < a ? b : a, high = b < a ? a : b;
  a = low;
  b = high;
}

PLICA_INLINE void order(float& a, float& b, float& c, float& d, float& e) {
  order(a, b);
  order(d, e);
  order(c, e);
  order(c, d);
  order(a, d);
  order(a, c);
  order(b, e);
  order(b, d);
  order(b, c);
}

PLICA_INLINE float low(float a, float b) { return b < a ? b : a; }
PLICA_INLINE float high(float a, float b) { return b < a ? a : b; }

/// Sorts each column of five rows: s0 is the least.
PLICA_INLINE void sort_columns_body(const float* r0, const float* r1, const float* r2, const float* r3,
                                    const float* r4, float* __restrict__ s0, float* __restrict__ s1,
                                    float* __restrict__ s2, float* __restrict__ s3, float* __restrict__ s4,
                                    std::ptrdiff_t n) {
  PLICA_INDEPENDENT
  for (std::ptrdiff_t x = 0; x < n; ++x) {
    float a = r0[x], b = r1[x], c = r2[x], d = r3[x], e = r4[x];
    order(a, b, c, d, e);
    s0[x] = a;
    s1[x] = b;
    s2[x] = c;
    s3[x] = d;
    s4[x] = e;
  }
}
PLICA_VERSIONS(sort_columns,
               (const float* r0, const float* r1, const float* r2, const float* r3, const float* r4, float* s0,
                float* s1, float* s2, float* s3, float* s4, std::ptrdiff_t n),
               (r0, r1, r2, r3, r4, s0, s1, s2, s3, s4, n))

/// Median of columns x to x + 4, each sorted. With the rows sorted too, all entries before the antidiagonal's
/// neighbour lie below the median and all after above it; of the three antidiagonals left, the greatest of the
/// first, the middle one of the second and the least of the third enclose it.
PLICA_INLINE void middle_body(const float* s0, const float* s1, const float* s2, const float* s3, const float* s4,
                              float* __restrict__ result, std::ptrdiff_t n) {
  PLICA_INDEPENDENT
  for (std::ptrdiff_t x = 0; x < n; ++x) {
    float a0 = s0[x], a1 = s0[x + 1], a2 = s0[x + 2], a3 = s0[x + 3], a4 = s0[x + 4];
    float b0 = s1[x], b1 = s1[x + 1], b2 = s1[x + 2], b3 = s1[x + 3], b4 = s1[x + 4];
    float c0 = s2[x], c1 = s2[x + 1], c2 = s2[x + 2], c3 = s2[x + 3], c4 = s2[x + 4];
    float d0 = s3[x], d1 = s3[x + 1], d2 = s3[x + 2], d3 = s3[x + 3], d4 = s3[x + 4];
    float e0 = s4[x], e1 = s4[x + 1], e2 = s4[x + 2], e3 = s4[x + 3], e4 = s4[x + 4];
    order(a0, a1, a2, a3, a4);
    order(b0, b1, b2, b3, b4);
    order(c0, c1, c2, c3, c4);
    order(d0, d1, d2, d3, d4);
    order(e0, e1, e2, e3, e4);
    const float under = high(high(a3, b2), high(c1, d0));
    const float over = low(low(b4, c3), low(d2, e1));
    order(a4, b3, c2, d1, e0);
    result[x] = high(low(under, c2), low(high(under, c2), over));
  }
}
PLICA_VERSIONS(middle,
               (const float* s0, const float* s1, const float* s2, const float* s3, const float* s4, float* result,
                std::ptrdiff_t n),
               (s0, s1, s2, s3, s4, result, n))

}  // namespace

void median_5x5(const Plane& image, Plane& result) {
  require_picture("median_5x5", image);
  const std::ptrdiff_t rows = image.rows(), columns = image.cols(), pitch = columns + 4;
  result.resize(rows, columns);
  for_chunks(rows, chunk_rows(columns), [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    std::vector<float> buffer(static_cast<std::size_t>(5 * pitch));
    float* const s = buffer.data();
    for (std::ptrdiff_t y = begin; y < end; ++y) {
      const auto row = [&](std::ptrdiff_t k) { return image.data() + mirrored(y + k, rows) * columns; };
      sort_columns(row(-2), row(-1), row(0), row(1), row(2), s + 2, s + pitch + 2, s + 2 * pitch + 2,
                   s + 3 * pitch + 2, s + 4 * pitch + 2, columns);
      for (std::ptrdiff_t k = 0; k < 5; ++k) {
        float* const line = s + k * pitch + 2;
        for (std::ptrdiff_t i = 1; i <= 2; ++i) {
          line[-i] = line[mirrored(-i, columns)];
          line[columns - 1 + i] = line[mirrored(columns - 1 + i, columns)];
        }
      }
      middle(s, s + pitch, s + 2 * pitch, s + 3 * pitch, s + 4 * pitch, result.data() + y * columns, columns);
    }
  });
}

}  // namespace plica::imaging

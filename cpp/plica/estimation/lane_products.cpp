#include "plica/estimation/lane_products.hpp"

#include "plica/core/registers.hpp"
#include "plica/core/versions.hpp"

namespace plica::estimation {
namespace {

using Matrices = LaneProducts::Matrices;
using Force = LaneProducts::Force;

/// sum += the block row's products with one register of lanes of x, whose unknowns are `stride` numbers apart.
template <typename Width>
PLICA_INLINE void add_block(const double* block, const double* x, std::ptrdiff_t stride,
                            typename Width::Register sum[3]) {
  typedef typename Width::Register Register;
  const Register x0 = *reinterpret_cast<const Register*>(x), x1 = *reinterpret_cast<const Register*>(x + stride),
                 x2 = *reinterpret_cast<const Register*>(x + 2 * stride);
  for (int c = 0; c < 3; ++c) sum[c] += block[3 * c] * x0 + block[3 * c + 1] * x1 + block[3 * c + 2] * x2;
}

template <typename Width, int lanes>
PLICA_INLINE void force_body(const Matrices& m, const Force& of, std::ptrdiff_t begin, std::ptrdiff_t end,
                             double* squares) {
  typedef typename Width::Register Register;
  constexpr int width = sizeof(Register) / sizeof(double);
  for (int from = 0; from < lanes; from += width) {
    Register whole = {};
    for (std::ptrdiff_t i = begin; i < end; ++i) {
      Register elastic[3] = {}, viscous[3] = {};
      for (std::int32_t e = m.row_start[i]; e < m.row_start[i + 1]; ++e) {
        const std::ptrdiff_t at = 9 * static_cast<std::ptrdiff_t>(e);
        const std::ptrdiff_t x = 3 * lanes * static_cast<std::ptrdiff_t>(m.column[e]) + from;
        add_block<Width>(m.K + at, of.U + x, lanes, elastic);
        if (m.C) add_block<Width>(m.C + at, of.V + x, lanes, viscous);
      }
      for (int c = 0; c < 3; ++c) {
        const std::ptrdiff_t at = lanes * (3 * i + c) + from;
        const Register source = *reinterpret_cast<const Register*>(of.source + at);
        const Register b = (source - elastic[c] - viscous[c]) * of.free[3 * i + c];
        *reinterpret_cast<Register*>(of.b + at) = b;
        whole += b * b;
      }
    }
    *reinterpret_cast<Register*>(squares + from) = whole;
  }
}

template <typename Width, int lanes>
PLICA_INLINE void subtract_body(const Matrices& m, const double* d, double* r, std::ptrdiff_t begin,
                                std::ptrdiff_t end, double* squares) {
  typedef typename Width::Register Register;
  constexpr int width = sizeof(Register) / sizeof(double);
  for (int from = 0; from < lanes; from += width) {
    Register left = {};
    for (std::ptrdiff_t i = begin; i < end; ++i) {
      Register product[3] = {};
      for (std::int32_t e = m.row_start[i]; e < m.row_start[i + 1]; ++e)
        add_block<Width>(m.A + 9 * static_cast<std::ptrdiff_t>(e),
                         d + 3 * lanes * static_cast<std::ptrdiff_t>(m.column[e]) + from, lanes, product);
      for (int c = 0; c < 3; ++c) {
        Register* at = reinterpret_cast<Register*>(r + lanes * (3 * i + c) + from);
        *at -= product[c];
        left += *at * *at;
      }
    }
    *reinterpret_cast<Register*>(squares + from) = left;
  }
}

#define PLICA_LANE_PRODUCTS(suffix, Width, lanes, target)                                                     \
  target void force##lanes##_##suffix(const Matrices& m, const Force& of, std::ptrdiff_t begin,               \
                                      std::ptrdiff_t end, double* squares) {                                  \
    force_body<Width, lanes>(m, of, begin, end, squares);                                                     \
  }                                                                                                           \
  target void subtract##lanes##_##suffix(const Matrices& m, const double* d, double* r, std::ptrdiff_t begin, \
                                         std::ptrdiff_t end, double* squares) {                               \
    subtract_body<Width, lanes>(m, d, r, begin, end, squares);                                                \
  }
#define PLICA_LANE_VERSION(suffix, Width, target)                                                 \
  PLICA_LANE_PRODUCTS(suffix, Width, 8, target)                                                   \
  PLICA_LANE_PRODUCTS(suffix, Width, 16, target)                                                  \
  constexpr LaneProducts products_##suffix{force8_##suffix, force16_##suffix, subtract8_##suffix, \
                                           subtract16_##suffix};
PLICA_LANE_VERSION(any, FourDoubles, )
PLICA_LANE_VERSION(fused, FourDoubles, PLICA_FUSED)
PLICA_LANE_VERSION(largest, EightDoubles, PLICA_LARGEST)
#undef PLICA_LANE_VERSION
#undef PLICA_LANE_PRODUCTS

}  // namespace

const LaneProducts& lane_products() {
  static const LaneProducts& chosen = takes_largest() ? products_largest
                                      : takes_fused() ? products_fused
                                                      : products_any;
  return chosen;
}

}  // namespace plica::estimation

#include "plica/imaging/spline.hpp"

#include <cmath>
#include <cstring>

#include "plica/core/versions.hpp"

namespace plica::imaging {
namespace {

// The samples are s = (c[-1] + 4 c[0] + c[1]) / 6. Its inverse is a causal and an anticausal recursion with the
// pole z = sqrt(3) - 2, each started from the symmetric continuation of the samples.
const double pole = std::sqrt(3.0) - 2.0;
constexpr std::ptrdiff_t horizon = 24;  // |z|^24 = 2e-14

void filter_rows(Plane& c) {
  const std::ptrdiff_t n = c.rows();
  const auto z = static_cast<float>(pole);
  Eigen::Array<float, 1, Eigen::Dynamic> first = c.row(0);
  double power = pole;
  for (std::ptrdiff_t k = 0; k < horizon; ++k, power *= pole) {
    first += static_cast<float>(power) * c.row(mirrored(k, n));
  }
  c.row(0) = first;
  for (std::ptrdiff_t i = 1; i < n; ++i) c.row(i) += z * c.row(i - 1);
  c.row(n - 1) *= z / (z - 1);
  for (std::ptrdiff_t i = n - 2; i >= 0; --i) c.row(i) = z * (c.row(i + 1) - c.row(i));
  c *= 6.0F;
}

using Four = float __attribute__((vector_size(16)));

PLICA_INLINE Four load(const float* from) {
  Four four;
  std::memcpy(&four, from, sizeof four);
  return four;
}

/// The four cubic B-splines at t in [0, 1] past the second knot.
PLICA_INLINE Four weights(float t) {
  constexpr Four c0{1.0F / 6, 4.0F / 6, 1.0F / 6, 0.0F}, c1{-0.5F, 0.0F, 0.5F, 0.0F}, c2{0.5F, -1.0F, 0.5F, 0.0F},
      c3{-1.0F / 6, 0.5F, -0.5F, 1.0F / 6};
  return c0 + t * (c1 + t * (c2 + t * c3));
}

/// Pixel i moved by d among n: the knot before it and the way past that, kept inside; false where it is outside.
PLICA_INLINE bool place(std::ptrdiff_t i, float d, std::ptrdiff_t n, std::ptrdiff_t& knot, float& t) {
  const float bounded = d > -1e6F ? (d < 1e6F ? d : 1e6F) : -1e6F;  // what is not a number is outside
  auto whole = static_cast<std::ptrdiff_t>(bounded);
  whole -= static_cast<float>(whole) > bounded;
  knot = i + whole;
  t = bounded - static_cast<float>(whole);
  if (knot >= 0 && knot < n - 1) return true;
  const bool at_end = knot == n - 1 && t == 0;
  t = knot < 0 ? 0.0F : 1.0F;
  knot = knot < 0 ? 0 : n - 2;
  return at_end;
}

/// Row y of the warped picture from the coefficients, which have one more on each side.
PLICA_INLINE void warp_body(const float* coefficients, std::ptrdiff_t rows, std::ptrdiff_t columns,
                            std::ptrdiff_t y, const float* u, const float* v, float* warped, float* inside) {
  const std::ptrdiff_t pitch = columns + 2;
  for (std::ptrdiff_t x = 0; x < columns; ++x) {
    std::ptrdiff_t column, row;
    float s, t;
    const bool in_columns = place(x, u[x], columns, column, s);
    const bool in_rows = place(y, v[x], rows, row, t);
    const float* c = coefficients + row * pitch + column;
    const Four down = weights(t);
    const Four sum = weights(s) * ((down[0] * load(c) + down[1] * load(c + pitch)) +
                                   (down[2] * load(c + 2 * pitch) + down[3] * load(c + 3 * pitch)));
    warped[x] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
    inside[x] = in_columns && in_rows ? 1.0F : 0.0F;
  }
}
PLICA_VERSIONS(warp,
               (const float* coefficients, std::ptrdiff_t rows, std::ptrdiff_t columns, std::ptrdiff_t y,
                const float* u, const float* v, float* warped, float* inside),
               (coefficients, rows, columns, y, u, v, warped, inside))

}  // namespace

Spline::Spline(const Plane& image)
    : rows_((require_at_least("Spline", "rows of the picture", image.rows(), 2),
             require_at_least("Spline", "columns of the picture", image.cols(), 2), image.rows())),
      columns_(image.cols()),
      coefficients_(rows_ + 2, columns_ + 2) {
  Plane c = image;
  filter_rows(c);
  Plane across = c.transpose();
  filter_rows(across);
  coefficients_.block(1, 1, rows_, columns_) = across.transpose();
  coefficients_.col(0) = coefficients_.col(1);
  coefficients_.col(columns_ + 1) = coefficients_.col(columns_);
  coefficients_.row(0) = coefficients_.row(1);
  coefficients_.row(rows_ + 1) = coefficients_.row(rows_);
}

void Spline::warp_row(std::ptrdiff_t y, const Plane& u, const Plane& v, Eigen::Ref<PlaneRow> warped,
                      Eigen::Ref<PlaneRow> inside) const {
  require_index("Spline", "row", y, rows_);
  for (const Plane* plane : {&u, &v}) {
    require_size("Spline", "rows of the flow", plane->rows(), rows_);
    require_size("Spline", "columns of the flow", plane->cols(), columns_);
  }
  for (const auto* row : {&warped, &inside}) require_size("Spline", "a row", row->size(), columns_);
  warp(coefficients_.data(), rows_, columns_, y, u.data() + y * columns_, v.data() + y * columns_, warped.data(),
       inside.data());
}

}  // namespace plica::imaging

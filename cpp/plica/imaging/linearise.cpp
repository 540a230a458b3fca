#include "plica/imaging/linearise.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"
#include "plica/core/versions.hpp"

namespace plica::imaging {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

PLICA_INLINE void mean_body(const float* a, const float* b, std::ptrdiff_t n, float* __restrict__ mean,
                            float* __restrict__ difference) {
  PLICA_INDEPENDENT
  for (std::ptrdiff_t x = 0; x < n; ++x) {
    mean[x] = 0.5F * (a[x] + b[x]);
    difference[x] = b[x] - a[x];
  }
}
PLICA_VERSIONS(mean, (const float* a, const float* b, std::ptrdiff_t n, float* half, float* difference),
               (a, b, n, half, difference))

PLICA_INLINE void derivative_body(const float* m2, const float* m1, const float* p1, const float* p2,
                                  std::ptrdiff_t n, float* __restrict__ result) {
  PLICA_INDEPENDENT
  for (std::ptrdiff_t x = 0; x < n; ++x) {
    result[x] = (2.0F / 3.0F) * (p1[x] - m1[x]) - (1.0F / 12.0F) * (p2[x] - m2[x]);
  }
}
PLICA_VERSIONS(derivative,
               (const float* m2, const float* m1, const float* p1, const float* p2, std::ptrdiff_t n,
                float* result),
               (m2, m1, p1, p2, n, result))

PLICA_INLINE void normalise_body(float noise, std::ptrdiff_t n, float* __restrict__ ix, float* __restrict__ iy,
                                 float* __restrict__ it) {
  PLICA_INDEPENDENT
  for (std::ptrdiff_t x = 0; x < n; ++x) {
    const float scale = 1.0F / std::sqrt(ix[x] * ix[x] + iy[x] * iy[x] + noise * noise);
    ix[x] *= scale;
    iy[x] *= scale;
    it[x] *= scale;
  }
}
PLICA_VERSIONS(normalise, (float noise, std::ptrdiff_t n, float* ix, float* iy, float* it), (noise, n, ix, iy, it))

/// Linear interpolation at a place in the picture.
float at(const Plane& image, float x, float y) {
  const auto i = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(x), 0, image.cols() - 2);
  const auto j = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(y), 0, image.rows() - 2);
  const float s = x - static_cast<float>(i), t = y - static_cast<float>(j);
  return (1 - t) * ((1 - s) * image(j, i) + s * image(j, i + 1)) +
         t * ((1 - s) * image(j + 1, i) + s * image(j + 1, i + 1));
}

/// Continues a row by two on each side.
void continue_row(float* line, std::ptrdiff_t columns) {
  for (std::ptrdiff_t i = 1; i <= 2; ++i) {
    line[-i] = line[mirrored(-i, columns)];
    line[columns - 1 + i] = line[mirrored(columns - 1 + i, columns)];
  }
}

/// The derivatives of a picture that has two more columns on each side.
void differentiate(const Plane& continued, Plane& along, Plane& down) {
  const std::ptrdiff_t rows = continued.rows(), columns = continued.cols() - 4;
  along.resize(rows, columns);
  down.resize(rows, columns);
  for_chunks(rows, chunk_rows(columns), [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    for (std::ptrdiff_t y = begin; y < end; ++y) {
      const auto line = [&](std::ptrdiff_t k) {
        return continued.data() + mirrored(y + k, rows) * (columns + 4) + 2;
      };
      derivative(line(0) - 2, line(0) - 1, line(0) + 1, line(0) + 2, columns, along.data() + y * columns);
      derivative(line(-2), line(-1), line(1), line(2), columns, down.data() + y * columns);
    }
  });
}

}  // namespace

void linearise(const Plane& first, const Spline& second, const Plane& used, const Plane& u, const Plane& v,
               Linearisation& result) {
  for (const Plane* plane : {&u, &v}) require_like("linearise", "the flow", *plane, first);
  if (used.size() > 0) require_like("linearise", "the mask", used, first);
  require_size("linearise", "rows of the spline", second.rows(), first.rows());
  require_size("linearise", "columns of the spline", second.columns(), first.cols());
  const std::ptrdiff_t rows = first.rows(), columns = first.cols();
  Plane mean_image(rows, columns + 4);  // two more on each side
  for (Plane* plane : {&result.it, &result.trust}) plane->resize(rows, columns);
  for_chunks(rows, chunk_rows(columns), [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    PlaneRow warped(columns);
    for (std::ptrdiff_t y = begin; y < end; ++y) {
      second.warp_row(y, u, v, warped, result.trust.row(y));
      float* const line = mean_image.data() + y * (columns + 4) + 2;
      mean(first.data() + y * columns, warped.data(), columns, line, result.it.data() + y * columns);
      continue_row(line, columns);
      if (used.size() > 0) result.trust.row(y) *= used.row(y);
    }
  });
  differentiate(mean_image, result.ix, result.iy);
}

void normalise(float noise, Linearisation& channel) {
  require_like("normalise", "ix", channel.ix, channel.it);
  require_like("normalise", "iy", channel.iy, channel.it);
  const std::ptrdiff_t columns = channel.it.cols();
  for_chunks(channel.it.rows(), chunk_rows(columns),
             [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
               const std::ptrdiff_t from = begin * columns;
               normalise(noise, (end - begin) * columns, channel.ix.data() + from, channel.iy.data() + from,
                         channel.it.data() + from);
             });
}

Gradient gradient(const Plane& image) {
  require_picture("gradient", image);
  const std::ptrdiff_t columns = image.cols();
  Plane continued(image.rows(), columns + 4);
  continued.middleCols(2, columns) = image;
  for (std::ptrdiff_t y = 0; y < image.rows(); ++y) continue_row(&continued(y, 2), columns);
  Gradient result;
  differentiate(continued, result.x, result.y);
  return result;
}

Plane residual(const Plane& first, const Plane& second, const Plane& u, const Plane& v) {
  require_like("residual", "second", second, first);
  require_like("residual", "u", u, first);
  require_like("residual", "v", v, first);
  const Spline spline(second);
  const std::ptrdiff_t columns = first.cols();
  Plane result(first.rows(), columns);
  for_chunks(first.rows(), chunk_rows(columns), [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    PlaneRow warped(columns), inside(columns);
    for (std::ptrdiff_t y = begin; y < end; ++y) {
      spline.warp_row(y, u, v, warped, inside);
      result.row(y) = (inside > 0).select(warped - first.row(y), nan);
    }
  });
  return result;
}

Flow round_trip(const Flow& forward, const Flow& backward) {
  require_picture("round_trip", forward.u);
  require_like("round_trip", "forward.v", forward.v, forward.u);
  require_like("round_trip", "backward.u", backward.u, forward.u);
  require_like("round_trip", "backward.v", backward.v, forward.u);
  const std::ptrdiff_t rows = forward.u.rows(), columns = forward.u.cols();
  Flow result{Plane(rows, columns), Plane(rows, columns)};
  for_chunks(rows, chunk_rows(columns), [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    for (std::ptrdiff_t y = begin; y < end; ++y) {
      for (std::ptrdiff_t x = 0; x < columns; ++x) {
        const float to_x = static_cast<float>(x) + forward.u(y, x), to_y = static_cast<float>(y) + forward.v(y, x);
        if (!(to_x >= 0 && to_x <= static_cast<float>(columns - 1) && to_y >= 0 &&
              to_y <= static_cast<float>(rows - 1))) {
          result.u(y, x) = result.v(y, x) = nan;
          continue;
        }
        result.u(y, x) = forward.u(y, x) + at(backward.u, to_x, to_y);
        result.v(y, x) = forward.v(y, x) + at(backward.v, to_x, to_y);
      }
    }
  });
  return result;
}

}  // namespace plica::imaging

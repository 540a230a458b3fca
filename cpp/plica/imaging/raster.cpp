#include "plica/imaging/raster.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"

namespace plica::imaging {
namespace {

constexpr double flat = 1e-12;  // px^2: a triangle seen edge-on
constexpr double edge = 1e-9;   // of barycentric coordinates: no gap between neighbours
constexpr double none = -std::numeric_limits<double>::infinity();

/// a + b x + c y.
struct Plane3 {
  double a, b, c;
  double at(double x, double y) const { return a + b * x + c * y; }
};

/// A triangle that faces the camera: barycentric coordinates and height as planes, and its bounding box.
struct Seen {
  std::array<Plane3, 3> share;
  Plane3 height;
  double left, right, top, bottom;

  bool holds(double x, double y) const {
    return share[0].at(x, y) >= -edge && share[1].at(x, y) >= -edge && share[2].at(x, y) >= -edge;
  }
};

/// False where it does not face the camera (rows count downwards, so that it then has an area above 0) or is not
/// finite.
bool look_at(const Points& corners, const Triangles& triangles, std::ptrdiff_t t, Seen& seen) {
  std::array<double, 3> x{}, y{}, z{};
  for (int k = 0; k < 3; ++k) {
    const auto corner = corners.row(triangles(t, k));
    x[static_cast<std::size_t>(k)] = corner[0];
    y[static_cast<std::size_t>(k)] = corner[1];
    z[static_cast<std::size_t>(k)] = corner[2];
  }
  const double area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
  if (!(area < -flat && std::isfinite(area) && std::isfinite(z[0] + z[1] + z[2]))) return false;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
    seen.share[k] = {(x[i] * y[j] - x[j] * y[i]) / area, (y[i] - y[j]) / area, (x[j] - x[i]) / area};
  }
  const auto& s = seen.share;
  seen.height = {z[0] * s[0].a + z[1] * s[1].a + z[2] * s[2].a, z[0] * s[0].b + z[1] * s[1].b + z[2] * s[2].b,
                 z[0] * s[0].c + z[1] * s[1].c + z[2] * s[2].c};
  seen.left = std::min({x[0], x[1], x[2]});
  seen.right = std::max({x[0], x[1], x[2]});
  seen.top = std::min({y[0], y[1], y[2]});
  seen.bottom = std::max({y[0], y[1], y[2]});
  return true;
}

/// Whole numbers from `first` to `last` within [0, count).
struct Range {
  std::ptrdiff_t begin, end;
};

Range within_picture(double first, double last, std::ptrdiff_t count) {
  const auto most = static_cast<double>(count);
  return {static_cast<std::ptrdiff_t>(std::clamp(first, 0.0, most)),
          static_cast<std::ptrdiff_t>(std::clamp(last, -1.0, most - 1)) + 1};
}

void check(const char* where, const Points& corners, const Triangles& triangles) {
  require_indices(where, "triangles", triangles, corners.rows());
}

}  // namespace

TriangleRaster rasterise_triangles(const Points& corners, const Triangles& triangles, const PixelMask& within) {
  check("rasterise_triangles", corners, triangles);
  const std::ptrdiff_t rows = within.rows(), columns = within.cols();
  TriangleRaster raster;
  raster.triangle.setConstant(rows, columns, -1);
  Vector nearest = Vector::Constant(rows * columns, none);
  std::vector<Seen> seen(static_cast<std::size_t>(triangles.rows()));
  for (std::ptrdiff_t t = 0; t < triangles.rows(); ++t) {
    Seen& own = seen[static_cast<std::size_t>(t)];
    if (!look_at(corners, triangles, t, own)) continue;
    const Range across = within_picture(std::ceil(own.left - edge), std::floor(own.right + edge), columns);
    const Range down = within_picture(std::ceil(own.top - edge), std::floor(own.bottom + edge), rows);
    for (std::ptrdiff_t row = down.begin; row < down.end; ++row) {
      const auto y = static_cast<double>(row);
      for (std::ptrdiff_t column = across.begin; column < across.end; ++column) {
        const auto x = static_cast<double>(column);
        if (!own.holds(x, y)) continue;
        const double height = own.height.at(x, y);
        double& before = nearest[row * columns + column];
        if (height < before) continue;  // of equal heights the last is shown
        before = height;
        raster.triangle(row, column) = static_cast<std::int32_t>(t);
      }
    }
  }
  raster.triangle = within.select(raster.triangle.array(), -1).matrix();
  raster.share.resize((raster.triangle.array() >= 0).count(), 3);
  std::ptrdiff_t p = 0;
  for (std::ptrdiff_t row = 0; row < rows; ++row) {
    for (std::ptrdiff_t column = 0; column < columns; ++column) {
      const std::int32_t t = raster.triangle(row, column);
      if (t < 0) continue;
      const Seen& own = seen[static_cast<std::size_t>(t)];
      for (std::size_t k = 0; k < 3; ++k) {
        raster.share(p, static_cast<std::ptrdiff_t>(k)) =
            own.share[k].at(static_cast<double>(column), static_cast<double>(row));
      }
      ++p;
    }
  }
  return raster;
}

Vector heights_above(const Pairs& places, const Points& corners, const Triangles& triangles, std::ptrdiff_t rows,
                     std::ptrdiff_t columns) {
  const char* const where = "heights_above";
  check(where, corners, triangles);
  require_at_least(where, "rows", rows, 0);
  require_at_least(where, "columns", columns, 0);
  std::vector<Seen> seen;
  std::vector<std::ptrdiff_t> start(static_cast<std::size_t>(rows * columns) + 1, 0);
  const auto over_squares = [&](const Seen& own, const auto& visit) {
    const Range across = within_picture(std::floor(own.left), std::floor(own.right), columns);
    const Range down = within_picture(std::floor(own.top), std::floor(own.bottom), rows);
    for (std::ptrdiff_t row = down.begin; row < down.end; ++row)
      for (std::ptrdiff_t column = across.begin; column < across.end; ++column)
        visit(static_cast<std::size_t>(row * columns + column));
  };
  for (std::ptrdiff_t t = 0; t < triangles.rows(); ++t) {
    Seen own{};
    if (!look_at(corners, triangles, t, own)) continue;
    over_squares(own, [&](std::size_t square) { ++start[square + 1]; });
    seen.push_back(own);
  }
  for (std::size_t square = 1; square < start.size(); ++square) start[square] += start[square - 1];
  std::vector<std::size_t> listed(static_cast<std::size_t>(start.back()));
  std::vector<std::ptrdiff_t> next(start.begin(), start.end() - 1);
  for (std::size_t k = 0; k < seen.size(); ++k)
    over_squares(seen[k], [&](std::size_t square) { listed[static_cast<std::size_t>(next[square]++)] = k; });
  Vector found = Vector::Constant(places.rows(), none);
  for_slices(places.rows(), [&](std::ptrdiff_t at, std::ptrdiff_t count) {
    for (std::ptrdiff_t p = at; p < at + count; ++p) {
      const double x = places(p, 0), y = places(p, 1);
      if (!(x >= 0 && y >= 0 && x < static_cast<double>(columns) && y < static_cast<double>(rows))) continue;
      const auto square =
          static_cast<std::size_t>(static_cast<std::ptrdiff_t>(y) * columns + static_cast<std::ptrdiff_t>(x));
      for (auto k = start[square]; k < start[square + 1]; ++k) {
        const Seen& own = seen[listed[static_cast<std::size_t>(k)]];
        if (own.holds(x, y)) found[p] = std::max(found[p], own.height.at(x, y));
      }
    }
  });
  return found;
}

}  // namespace plica::imaging

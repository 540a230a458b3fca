#pragma once
// What an orthographic camera sees of triangles: positions are column px, row px (downwards) and height towards
// it.
#include <Eigen/Core>

#include "plica/core/types.hpp"

namespace plica::imaging {

/// (p, 2) column and row, or the two coordinates of a place in a face.
using Pairs = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;
/// (rows, columns) of a picture.
using PixelMask = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Which triangle the centres of pixels show.
struct TriangleRaster {
  Eigen::Matrix<std::int32_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> triangle;  // of each pixel, or -1
  Points share;  // (p, 3) barycentric coordinates in it, of the pixels that show one, row by row
};

/// The nearest triangle at each pixel's centre among those that face the camera, with a depth buffer.
/// corners (v, 3); triangles (t, 3) rows of corners, anticlockwise seen from outside; `within` (rows, columns):
/// pixels that may show one. A triangle that is not finite is not seen. O(sum of the triangles' bounding boxes +
/// pixels).
TriangleRaster rasterise_triangles(const Points& corners, const Triangles& triangles, const PixelMask& within);

/// The greatest height at each place (p, 2) of the triangles that face the camera in a picture of this size; -inf
/// where there is none. A place is tried with the triangles that meet its pixel's unit square.
Vector heights_above(const Pairs& places, const Points& corners, const Triangles& triangles, std::ptrdiff_t rows,
                     std::ptrdiff_t columns);

}  // namespace plica::imaging

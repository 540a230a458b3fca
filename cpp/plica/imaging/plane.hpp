#pragma once
#include <algorithm>
#include <cstddef>

#include "plica/core/types.hpp"

namespace plica {

/// A picture, or one component of a flow: (rows, columns), row 0 on top. Values belong to pixel centres.
using Plane = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Continues n samples as c b a | a b c ... x y z | z y x: the symmetric border of every filter here.
inline std::ptrdiff_t mirrored(std::ptrdiff_t i, std::ptrdiff_t n) {
  while (i < 0 || i >= n) i = i < 0 ? -1 - i : 2 * n - 1 - i;
  return i;
}

/// Rows of one chunk of threaded work; depends on the size of the picture alone.
inline std::ptrdiff_t chunk_rows(std::ptrdiff_t columns) {
  return std::max<std::ptrdiff_t>(1, 12288 / std::max<std::ptrdiff_t>(1, columns));
}

}  // namespace plica

#pragma once
#include <algorithm>
#include <cstddef>

#include "plica/core/require.hpp"
#include "plica/core/types.hpp"

namespace plica::imaging {

/// A picture, or one component of a flow: (rows, columns), row 0 on top. Values belong to pixel centres.
using Plane = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// One of its rows.
using PlaneRow = Eigen::Array<float, 1, Eigen::Dynamic>;

/// Continues n samples as c b a | a b c ... x y z | z y x: the symmetric border of every filter here.
inline std::ptrdiff_t mirrored(std::ptrdiff_t i, std::ptrdiff_t n) {
  while (i < 0 || i >= n) i = i < 0 ? -1 - i : 2 * n - 1 - i;
  return i;
}

/// Throws InvalidInput for a picture without pixels, which has no border to continue.
inline void require_picture(const char* where, const Plane& image) {
  require_at_least(where, "the picture", image.size(), 1);
}
/// Throws InvalidInput unless a plane is as large as that picture.
inline void require_like(const char* where, const char* name, const Plane& plane, const Plane& picture) {
  require_size(where, (std::string("rows of ") + name).c_str(), plane.rows(), picture.rows());
  require_size(where, (std::string("columns of ") + name).c_str(), plane.cols(), picture.cols());
}

/// Rows of one chunk of threaded work; depends on the size of the picture alone.
inline std::ptrdiff_t chunk_rows(std::ptrdiff_t columns) {
  return std::max<std::ptrdiff_t>(1, 12288 / std::max<std::ptrdiff_t>(1, columns));
}

}  // namespace plica::imaging

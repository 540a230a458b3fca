#pragma once
#include "plica/imaging/plane.hpp"

namespace plica::imaging {

/// The cubic B-spline through the pixels of a picture (symmetric borders): exact on cubics away from the border.
class Spline {
 public:
  explicit Spline(const Plane& image);

  std::ptrdiff_t rows() const { return rows_; }
  std::ptrdiff_t columns() const { return columns_; }

  /// Row y of the warped picture, S(x + u, y + v), and 1 where that place lies in the picture, 0 where not
  /// (there: the value at the nearest place that does); u, v as large as the picture, rows (columns).
  void warp_row(std::ptrdiff_t y, const Plane& u, const Plane& v, Eigen::Ref<PlaneRow> warped,
                Eigen::Ref<PlaneRow> inside) const;

 private:
  std::ptrdiff_t rows_, columns_;
  Plane coefficients_;  // with one more on each side
};

}  // namespace plica::imaging

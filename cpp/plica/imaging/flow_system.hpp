#pragma once
#include <array>
#include <cmath>
#include <vector>

#include "plica/imaging/plane.hpp"

namespace plica::imaging {

/// Weight of a squared error e2 in a linear solve: rho'(e) / e = constant + share / (offset + e2), or with the
/// root of that sum.
struct Weight {
  float constant, share, offset;
  bool rooted = false;

  float operator()(float e2) const {
    const float sum = offset + e2;
    return constant + share / (rooted ? std::sqrt(sum) : sum);
  }
};

/// One channel of the data term about a flow (u0, v0): e = it + ix (u - u0) + iy (v - v0), and the weight of each
/// pixel, 0 where it says nothing.
struct Linearisation {
  Plane ix, iy, it, trust;
};

/// The linear equations of one warp, docs/imaging.md: for each pixel
///   sum over channels of w_D e (ix, iy) + lambda sum over its four neighbours of w_S (u - u_neighbour) = 0,  v
///   alike,
/// the weights w_D, w_S taken at (u0, v0). Pixels are kept in two colours like a chess board's, each colour's
/// contiguous: a sweep over one reads only the other, in unit strides and in any order.
class FlowSystem {
 public:
  FlowSystem(std::ptrdiff_t rows, std::ptrdiff_t columns);

  /// Between neighbours of which `sides` says that they are on opposite ones (a negative product), w_S is a
  /// thousandth of itself; an empty `sides` knows none.
  void assemble(const std::vector<Linearisation>& channels, const Plane& u0, const Plane& v0, Weight data_weight,
                Weight smooth_weight, float lambda, const Plane& sides = {});

  /// Successive over-relaxation from the present values: 76 bytes a pixel and sweep.
  void sweep(int count, float relaxation);

  /// The present values.
  void read(Plane& u, Plane& v) const;

 private:
  /// Half of the pixels: (x, y) with (x + y) mod 2 = colour, entry i of row y is x = 2 i + (y + colour) mod 2.
  /// A row has one entry of padding on each side and there is a row of padding above and below; all of it is 0.
  struct Colour {
    std::vector<float> u, v;
    std::vector<float> b1, b2, inverse11, inverse12, inverse22;
    std::vector<float> right_u, down_u, right_v, down_v;  // lambda w_S to the neighbour to the right, below
  };

  std::ptrdiff_t at(std::ptrdiff_t y, std::ptrdiff_t i) const { return (y + 1) * pitch_ + 1 + i; }

  std::ptrdiff_t rows_, columns_, half_, pitch_;
  std::array<Colour, 2> colours_;
};

}  // namespace plica::imaging

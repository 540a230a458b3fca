#include "plica/imaging/texture.hpp"

#include <array>
#include <cmath>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"

namespace plica::imaging {
namespace {

/// The samples about a position of one index, and their weights.
template <int count>
struct Taps {
  std::array<std::ptrdiff_t, count> index;
  std::array<double, count> weight;

  Taps(double position, std::ptrdiff_t n) {
    const double whole = std::floor(position), y = position - whole, z = 1 - y;
    if constexpr (count == 2) {
      weight = {z, y};
    } else {
      weight = {z * z * z / 6, (y * y * (y - 2) * 3 + 4) / 6, (z * z * (z - 2) * 3 + 4) / 6, y * y * y / 6};
    }
    const auto size = static_cast<double>(n);
    auto at = static_cast<std::ptrdiff_t>(whole - size * std::floor(whole / size)) - (count == 2 ? 0 : 1);
    for (auto& own : index) {
      own = at < 0 ? at + n : at >= n ? at - n : at;
      ++at;
    }
  }
};

template <int count>
double sampled(const double* tile, std::ptrdiff_t n, const double* place) {
  const Taps<count> i(place[0], n), j(place[1], n), k(place[2], n);
  double sum = 0;
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = 0; b < count; ++b) {
      const double* const line = tile + (i.index[a] * n + j.index[b]) * n;
      double along = 0;
      for (std::size_t c = 0; c < count; ++c) along += k.weight[c] * line[k.index[c]];
      sum += i.weight[a] * j.weight[b] * along;
    }
  }
  return sum;
}

}  // namespace

Vector periodic_spline(const Eigen::Ref<const Vector>& tile, std::ptrdiff_t n, const Points& places, int degree) {
  const char* const where = "periodic_spline";
  require_at_least(where, "a side", n, 4);
  require_size(where, "tile", tile.size(), n * n * n);
  if (degree != 1 && degree != 3) throw InvalidInput(where, "degree", degree, "", "1 or 3");
  if (!places.allFinite()) throw InvalidInput("periodic_spline: places are not all finite; must be.");
  Vector values(places.rows());
  for_slices(places.rows(), [&](std::ptrdiff_t at, std::ptrdiff_t count) {
    for (std::ptrdiff_t p = at; p < at + count; ++p) {
      const double* const place = places.data() + 3 * p;
      values[p] = degree == 3 ? sampled<4>(tile.data(), n, place) : sampled<2>(tile.data(), n, place);
    }
  });
  return values;
}

}  // namespace plica::imaging

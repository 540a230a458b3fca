#include "plica/imaging/light.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "plica/core/threads.hpp"

namespace plica::imaging {
namespace {

constexpr std::ptrdiff_t blocks_along = 48;     // the shorter side, at least
constexpr std::size_t blocks_for_field = 1000;  // for all seven unknowns
constexpr double brightest = 0.98;              // of the range; above, a camera may be saturated
constexpr double least_gain = 0.05;             // what is told of light that falls further is noise
constexpr float counted_from = 0.99F;           // blurred ones are one to round-off
constexpr int refits = 12;

/// Means over the pixels that count of a block, and its place from -1 to 1.
struct Block {
  double first, second, x, y;
};

double from_middle(double i, std::ptrdiff_t n) { return (2 * i + 1) / static_cast<double>(n) - 1; }

std::array<double, 6> shapes(double x, double y) { return {1, x, y, x * x, x * y, y * y}; }

float brightest_of(const Plane& image) {
  const float low = image.minCoeff(), high = image.maxCoeff();
  return low + static_cast<float>(brightest) * (high - low);
}

std::vector<Block> means(const Plane& first, const Plane& second, const Spline& spline, const Plane& used,
                         const Plane& u, const Plane& v) {
  const std::ptrdiff_t rows = first.rows(), columns = first.cols();
  const std::ptrdiff_t side = std::max<std::ptrdiff_t>(1, std::min(rows, columns) / blocks_along);
  const std::ptrdiff_t down = rows / side, across = columns / side;
  const float top = brightest_of(first), top_then = brightest_of(second);
  std::vector<Block> all(static_cast<std::size_t>(down * across));
  std::vector<char> counts(all.size());
  for_chunks(down, chunk_rows(columns * side), [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    PlaneRow warped(columns), inside(columns);
    std::vector<double> sums(static_cast<std::size_t>(across)), sums_then(sums), number(sums);
    for (std::ptrdiff_t j = begin; j < end; ++j) {
      for (auto* sum : {&sums, &sums_then, &number}) std::fill(sum->begin(), sum->end(), 0.0);
      for (std::ptrdiff_t y = j * side; y < (j + 1) * side; ++y) {
        spline.warp_row(y, u, v, warped, inside);
        for (std::ptrdiff_t x = 0; x < across * side; ++x) {
          const auto block = static_cast<std::size_t>(x / side);
          const bool counted = inside[x] > 0 && first(y, x) < top && warped[x] < top_then &&
                               (used.size() == 0 || used(y, x) > counted_from);
          if (!counted) continue;
          sums[block] += static_cast<double>(first(y, x));
          sums_then[block] += static_cast<double>(warped[x]);
          number[block] += 1;
        }
      }
      for (std::ptrdiff_t i = 0; i < across; ++i) {
        const auto block = static_cast<std::size_t>(i), entry = static_cast<std::size_t>(j * across + i);
        if (number[block] < 0.5 * static_cast<double>(side * side)) continue;
        const double middle = 0.5 * static_cast<double>(side) - 0.5;
        counts[entry] = 1;
        all[entry] = {sums[block] / number[block], sums_then[block] / number[block],
                      from_middle(static_cast<double>(i * side) + middle, columns),
                      from_middle(static_cast<double>(j * side) + middle, rows)};
      }
    }
  });
  std::vector<Block> kept;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (counts[k]) kept.push_back(all[k]);
  }
  return kept;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Plane Light::gains(std::ptrdiff_t rows, std::ptrdiff_t columns) const {
  require_at_least("Light", "the rows", rows, 1);
  require_at_least("Light", "the columns", columns, 1);
  Plane result(rows, columns);
  for_chunks(rows, chunk_rows(columns), [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    for (std::ptrdiff_t j = begin; j < end; ++j) {
      const double y = from_middle(static_cast<double>(j), rows);
      const double c0 = gain[0] + y * (gain[2] + y * gain[5]), c1 = gain[1] + y * gain[4], c2 = gain[3];
      for (std::ptrdiff_t i = 0; i < columns; ++i) {
        const double x = from_middle(static_cast<double>(i), columns);
        result(j, i) = static_cast<float>(std::max(least_gain, c0 + x * (c1 + x * c2)));
      }
    }
  });
  return result;
}

Light fit_light(const Plane& first, const Plane& second, const Spline& spline, const Plane& used, const Plane& u,
                const Plane& v) {
  require_picture("fit_light", first);
  require_like("fit_light", "second", second, first);
  require_like("fit_light", "u", u, first);
  require_like("fit_light", "v", v, first);
  if (used.size() > 0) require_like("fit_light", "used", used, first);
  require_size("fit_light", "rows of the spline", spline.rows(), first.rows());
  require_size("fit_light", "columns of the spline", spline.columns(), first.cols());
  const std::vector<Block> blocks = means(first, second, spline, used, u, v);
  Light light;
  if (blocks.empty()) return light;
  const int terms = blocks.size() < blocks_for_field ? 1 : 7;
  double mean = 0, square = 0;
  for (const Block& block : blocks) {
    mean += block.first;
    square += block.first * block.first;
  }
  const auto count = static_cast<double>(blocks.size());
  mean /= count;
  square /= count;
  if (!(square > 0)) return light;
  const double level = std::sqrt(square);

  // The unknowns are the change, in units of the pictures' level: all of one size.
  Eigen::VectorXd change = Eigen::VectorXd::Zero(terms);
  std::vector<double> left(blocks.size()), size(blocks.size());
  const auto row = [&](const Block& block) {
    Eigen::Matrix<double, 7, 1> a;
    const auto shape = shapes(block.x, block.y);
    for (int k = 0; k < 6; ++k) a(k) = shape[static_cast<std::size_t>(k)] * block.first / level;
    a(6) = 1;
    return a;
  };
  for (int refit = 0; refit < refits; ++refit) {
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      left[k] = (blocks[k].second - blocks[k].first) / level - row(blocks[k]).head(terms).dot(change);
      size[k] = std::abs(left[k]);
    }
    const double scale = 2.4 * std::max(1.4826 * median(size), 1e-5);  // of Cauchy's penalty
    Eigen::MatrixXd normal = 1e-6 * count * Eigen::MatrixXd::Identity(terms, terms);
    Eigen::VectorXd side = -1e-6 * count * change;
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      const double ratio = left[k] / scale, weight = 1 / (1 + ratio * ratio);
      const auto a = row(blocks[k]).head(terms).eval();
      normal.noalias() += weight * a * a.transpose();
      side.noalias() += weight * left[k] * a;
    }
    const Eigen::VectorXd step = normal.ldlt().solve(side);
    change += step;
    if (step.cwiseAbs().maxCoeff() < 1e-6) break;
  }
  if (!change.allFinite()) return light;
  for (int k = 0; k < std::min(terms, 6); ++k) light.gain[static_cast<std::size_t>(k)] += change(k);
  if (terms == 7) light.offset = level * change(6);
  return light;
}

Relit relight(const Plane& first, const Plane& second, const Light& light) {
  require_picture("relight", first);
  require_like("relight", "second", second, first);
  const Plane gains = light.gains(first.rows(), first.cols());
  const auto offset = static_cast<float>(light.offset);
  return {first.min((second.maxCoeff() - offset) / gains), ((second - offset) / gains).min(first.maxCoeff())};
}

}  // namespace plica::imaging

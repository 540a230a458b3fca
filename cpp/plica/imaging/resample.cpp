#include "plica/imaging/resample.hpp"

#include <cmath>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"

namespace plica::imaging {
namespace {

std::vector<float> gaussian(double sigma) {
  const auto half = static_cast<std::ptrdiff_t>(std::lround(1.5 * sigma));
  std::vector<double> weights;
  double sum = 0;
  for (std::ptrdiff_t k = -half; k <= half; ++k) {
    weights.push_back(std::exp(-0.5 * static_cast<double>(k * k) / (sigma * sigma)));
    sum += weights.back();
  }
  std::vector<float> kernel;
  for (const double weight : weights) kernel.push_back(static_cast<float>(weight / sum));
  return kernel;
}

/// Where sample i of n_out lies among n_in: between `low` and `low + 1`, by `share`.
struct Sample {
  std::ptrdiff_t low, high;
  float share;
};

std::vector<Sample> places(std::ptrdiff_t n_in, std::ptrdiff_t n_out) {
  std::vector<Sample> all;
  for (std::ptrdiff_t i = 0; i < n_out; ++i) {
    const double x = (static_cast<double>(i) + 0.5) * static_cast<double>(n_in) / static_cast<double>(n_out) - 0.5;
    const double floor = std::floor(x);
    const auto low = static_cast<std::ptrdiff_t>(floor);
    all.push_back({std::clamp<std::ptrdiff_t>(low, 0, n_in - 1), std::clamp<std::ptrdiff_t>(low + 1, 0, n_in - 1),
                   static_cast<float>(x - floor)});
  }
  return all;
}

}  // namespace

Plane blur(const Plane& image, double sigma) {
  if (!(sigma >= 0) || !std::isfinite(sigma)) throw InvalidInput("blur", "sigma", sigma, "px", ">= 0 and finite");
  require_picture("blur", image);
  if (sigma == 0) return image;
  const std::vector<float> kernel = gaussian(sigma);
  const auto half = static_cast<std::ptrdiff_t>(kernel.size() / 2);
  const std::ptrdiff_t rows = image.rows(), columns = image.cols();
  Plane result(rows, columns);
  for_chunks(rows, chunk_rows(columns), [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    Eigen::Array<float, 1, Eigen::Dynamic> line(columns + 2 * half);
    for (std::ptrdiff_t y = begin; y < end; ++y) {
      auto middle = line.segment(half, columns);
      middle.setZero();
      for (std::ptrdiff_t k = -half; k <= half; ++k) {
        middle += kernel[static_cast<std::size_t>(k + half)] * image.row(mirrored(y + k, rows));
      }
      for (std::ptrdiff_t k = 1; k <= half; ++k) {
        line(half - k) = middle(mirrored(-k, columns));
        line(half + columns - 1 + k) = middle(mirrored(columns - 1 + k, columns));
      }
      result.row(y).setZero();
      for (std::ptrdiff_t k = 0; k <= 2 * half; ++k) {
        result.row(y) += kernel[static_cast<std::size_t>(k)] * line.segment(k, columns);
      }
    }
  });
  return result;
}

Plane resize(const Plane& image, std::ptrdiff_t rows, std::ptrdiff_t columns) {
  require_at_least("resize", "the rows", rows, 1);
  require_at_least("resize", "the columns", columns, 1);
  require_picture("resize", image);
  if (rows == image.rows() && columns == image.cols()) return image;
  const std::vector<Sample> down = places(image.rows(), rows), across = places(image.cols(), columns);
  Plane result(rows, columns);
  for_chunks(rows, chunk_rows(columns), [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    Eigen::Array<float, 1, Eigen::Dynamic> line(image.cols());
    for (std::ptrdiff_t y = begin; y < end; ++y) {
      const Sample& from = down[static_cast<std::size_t>(y)];
      line = image.row(from.low) + from.share * (image.row(from.high) - image.row(from.low));
      for (std::ptrdiff_t x = 0; x < columns; ++x) {
        const Sample& at = across[static_cast<std::size_t>(x)];
        result(y, x) = line(at.low) + at.share * (line(at.high) - line(at.low));
      }
    }
  });
  return result;
}

std::vector<Plane> pyramid(Plane image, int levels, double spacing) {
  require_picture("pyramid", image);
  require_at_least("pyramid", "the levels", levels, 1);
  if (!(spacing > 1) || !std::isfinite(spacing)) throw InvalidInput("pyramid", "spacing", spacing, "", "> 1");
  std::vector<Plane> all{std::move(image)};
  for (int level = 1; level < levels; ++level) {
    const Plane smooth = blur(all.back(), std::sqrt(spacing / 2));
    all.push_back(resize(smooth,
                         static_cast<std::ptrdiff_t>(std::ceil(static_cast<double>(smooth.rows()) / spacing)),
                         static_cast<std::ptrdiff_t>(std::ceil(static_cast<double>(smooth.cols()) / spacing))));
  }
  return all;
}

}  // namespace plica::imaging

// The filters against OpenCV's: a second algorithm for each, in tests only (docs/dependencies.md).
#include <doctest/doctest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "../pictures.hpp"
#include "plica/imaging/median.hpp"
#include "plica/imaging/resample.hpp"

using namespace plica;
using namespace plica::imaging;

namespace {

/// The same memory as OpenCV's picture, which only reads it.
cv::Mat shared(const Plane& image) {
  return {static_cast<int>(image.rows()), static_cast<int>(image.cols()), CV_32F,
          const_cast<float*>(image.data())};
}

Plane copy(const cv::Mat& image) {
  const cv::Mat whole = image.clone();
  return Eigen::Map<const Plane>(whole.ptr<float>(), whole.rows, whole.cols);
}

}  // namespace

TEST_CASE("the median is OpenCV's to the bit, with a symmetric border instead of a repeated one") {
  const std::ptrdiff_t sizes[][2] = {{30, 41}, {8, 8}, {97, 5}};
  for (const auto& size : sizes) {
    const Plane image = noise(size[0], size[1], 3, 11);
    Plane ours;
    median_5x5(image, ours);
    cv::Mat continued, theirs, repeated;
    cv::copyMakeBorder(shared(image), continued, 2, 2, 2, 2, cv::BORDER_REFLECT);
    cv::medianBlur(continued, theirs, 5);
    cv::medianBlur(shared(image), repeated, 5);
    const cv::Rect inside(2, 2, static_cast<int>(size[1]), static_cast<int>(size[0]));
    CHECK((ours == copy(theirs(inside))).all());
    const Plane off = (ours - copy(repeated)).abs();
    CHECK(off.block(2, 2, size[0] - 4, size[1] - 4).maxCoeff() == 0);
    CHECK(off.maxCoeff() > 0.1F);  // the border is where they part
  }
}

TEST_CASE("blurring is OpenCV's with the same kernel and a symmetric border") {
  for (const double sigma : {std::sqrt(0.625), 1.0, 1.4, 3.0}) {
    const auto half = static_cast<int>(std::lround(1.5 * sigma));
    const cv::Mat kernel = cv::getGaussianKernel(2 * half + 1, sigma, CV_32F);
    for (const Plane& image : {noise(37, 52, 128, 12), noise(9, 8, 128, 13)}) {
      cv::Mat symmetric, other;
      cv::sepFilter2D(shared(image), symmetric, CV_32F, kernel, kernel, {-1, -1}, 0, cv::BORDER_REFLECT);
      cv::sepFilter2D(shared(image), other, CV_32F, kernel, kernel, {-1, -1}, 0, cv::BORDER_REFLECT_101);
      const Plane ours = blur(image, sigma);
      CHECK((ours - copy(symmetric)).abs().maxCoeff() < 1e-4F);  // round-off of sums up to 128
      CHECK((ours - copy(other)).abs().maxCoeff() > 1);          // OpenCV's own border
    }
  }
}

TEST_CASE("resizing is OpenCV's linear one: pixel centres lie alike, and the edges too") {
  const Plane image = noise(38, 51, 128, 14);
  const std::ptrdiff_t sizes[][2] = {{19, 26}, {31, 41}, {76, 102}, {50, 33}, {8, 200}};
  for (const auto& size : sizes) {
    cv::Mat theirs;
    cv::resize(shared(image), theirs, cv::Size(static_cast<int>(size[1]), static_cast<int>(size[0])), 0, 0,
               cv::INTER_LINEAR);
    // Its places are in single precision: 50 px 2^-24, times a step of 256.
    CHECK((resize(image, size[0], size[1]) - copy(theirs)).abs().maxCoeff() < 1e-3F);
  }
}

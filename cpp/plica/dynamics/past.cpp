#include "plica/dynamics/past.hpp"

#include <cmath>

#include "plica/core/eigenpairs.hpp"
#include "plica/core/threads.hpp"

namespace plica {

void Past::add(Vector acceleration, Vector image) {
  if (accelerations.size() == depth) {
    accelerations.pop_back();
    images.pop_back();
  }
  accelerations.insert(accelerations.begin(), std::move(acceleration));
  images.insert(images.begin(), std::move(image));
}

Guess Past::nearest(const Vector& b) const {
  // Normal equations G c = Y^T b of |b - Y c|, Y the images, scaled to a diagonal of ones.
  constexpr double independent = 1e-11;  // of the largest eigenvalue of G; round-off leaves some 1e-15
  constexpr std::ptrdiff_t size = 2048;
  const auto count = static_cast<std::ptrdiff_t>(images.size());
  if (count == 0) return {Vector::Zero(b.size()), Vector::Zero(b.size())};
  const std::ptrdiff_t unknowns = b.size(), chunks = (unknowns + size - 1) / size;
  std::vector<Eigen::MatrixXd> parts(static_cast<std::size_t>(chunks), Eigen::MatrixXd::Zero(count, count + 1));
  for_chunks(unknowns, size, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t chunk) {
    Eigen::MatrixXd& part = parts[static_cast<std::size_t>(chunk)];
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const auto y = images[static_cast<std::size_t>(i)].segment(begin, end - begin);
      for (std::ptrdiff_t j = 0; j <= i; ++j)
        part(i, j) = y.dot(images[static_cast<std::size_t>(j)].segment(begin, end - begin));
      part(i, count) = y.dot(b.segment(begin, end - begin));
    }
  });
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(count, count + 1);
  for (const Eigen::MatrixXd& part : parts) sums += part;
  Vector scale(count);
  for (std::ptrdiff_t i = 0; i < count; ++i) scale[i] = sums(i, i) > 0 ? 1 / std::sqrt(sums(i, i)) : 0.0;
  const Eigen::MatrixXd G = scale.asDiagonal() * sums.leftCols(count) * scale.asDiagonal();
  const Eigenpairs modes = symmetric_eigenpairs(G);
  const Vector along = modes.vectors.transpose() * (scale.asDiagonal() * sums.col(count));
  Vector weights = Vector::Zero(count);
  for (std::ptrdiff_t k = 0; k < count; ++k)
    if (modes.values[k] > independent * modes.values[count - 1])
      weights += along[k] / modes.values[k] * modes.vectors.col(k);
  weights = scale.asDiagonal() * weights;
  Guess guess{Vector::Zero(unknowns), Vector::Zero(unknowns)};
  for_chunks(unknowns, size, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      guess.x.segment(begin, end - begin) += weights[i] * accelerations[k].segment(begin, end - begin);
      guess.product.segment(begin, end - begin) += weights[i] * images[k].segment(begin, end - begin);
    }
  });
  return guess;
}

}  // namespace plica

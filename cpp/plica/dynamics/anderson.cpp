#include "plica/dynamics/anderson.hpp"

#include <Eigen/QR>

#include "plica/core/require.hpp"

namespace plica {

void Anderson::forget() {
  images_.clear();
  residuals_.clear();
}

Vector Anderson::next(const Vector& x, const Vector& image) {
  require_size("Anderson", "the image", image.size(), x.size());
  if (!images_.empty()) require_size("Anderson", "x", x.size(), images_.back().size());
  images_.push_back(image);
  residuals_.push_back(image - x);
  if (static_cast<int>(images_.size()) > depth_ + 1) {
    images_.erase(images_.begin());
    residuals_.erase(residuals_.begin());
  }
  const auto columns = static_cast<std::ptrdiff_t>(images_.size()) - 1;
  if (columns == 0) return image;
  Eigen::MatrixXd differences(x.size(), columns);
  for (std::ptrdiff_t j = 0; j < columns; ++j) differences.col(j) = residuals_[j + 1] - residuals_[j];
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(differences);
  qr.setThreshold(1e-10);  // differences that repeat earlier ones carry only round-off
  const Vector weights = qr.solve(residuals_.back());
  Vector next = image;
  for (std::ptrdiff_t j = 0; j < columns; ++j) next -= weights[j] * (images_[j + 1] - images_[j]);
  return next;
}

}  // namespace plica

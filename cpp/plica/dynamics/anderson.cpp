#include "plica/dynamics/anderson.hpp"

#include <Eigen/QR>

#include "plica/core/require.hpp"

namespace plica {

void Anderson::forget() {
  image_.resize(0);
  residual_.resize(0);
  differences_.clear();
  taken_ = false;
}

void Anderson::take(Secant difference) {
  require_size("Anderson", "the residual of a difference", difference.residual.size(), difference.image.size());
  differences_.push_back(std::move(difference));
  taken_ = true;
}

Vector Anderson::next(const Vector& x, const Vector& image) {
  require_size("Anderson", "the image", image.size(), x.size());
  const Vector residual = image - x;
  if (image_.size() > 0) {
    require_size("Anderson", "x", x.size(), image_.size());
    if (taken_) differences_.clear();
    taken_ = false;
    differences_.push_back({image - image_, residual - residual_});
    if (static_cast<int>(differences_.size()) > depth_) differences_.erase(differences_.begin());
  }
  image_ = image;
  residual_ = residual;
  const auto columns = static_cast<std::ptrdiff_t>(differences_.size());
  if (columns == 0) return image;
  for (const Secant& known : differences_)
    require_size("Anderson", "a difference", known.residual.size(), x.size());
  Eigen::MatrixXd residuals(x.size(), columns);
  for (std::ptrdiff_t j = 0; j < columns; ++j) residuals.col(j) = differences_[j].residual;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(residuals);
  qr.setThreshold(1e-10);  // differences that repeat earlier ones carry only round-off
  const Vector weights = qr.solve(residual);
  Vector next = image;
  for (std::ptrdiff_t j = 0; j < columns; ++j) next -= weights[j] * differences_[j].image;
  return next;
}

}  // namespace plica

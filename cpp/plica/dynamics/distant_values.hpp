#pragma once
#include <cstdint>
#include <vector>

#include "plica/core/panel_matrix.hpp"

namespace plica {

/// Values that are linear in coordinates, rest + rows q, of which few are small: one changes by at most the norm
/// of its row times that of the change of q, so that most need not be computed to know that they are not. What is
/// computed is the same whatever was before.
class DistantValues {
 public:
  DistantValues() = default;
  DistantValues(Vector rest, const Eigen::MatrixXd& rows)
      : rest_(std::move(rest)),
        rows_(rows.transpose()),
        speed_(rows.rowwise().norm()),
        seen_(rest_),
        seen_at_(Vector::Zero(rest_.size())),
        seen_in_(static_cast<std::size_t>(rest_.size()), 0),
        q_(Vector::Zero(rows.cols())) {}

  std::ptrdiff_t size() const { return rest_.size(); }
  /// Takes up coordinates.
  void move(const Vector& q) {
    path_ += (1 + 1e-9) * (q - q_).norm();
    ++moves_;
    q_ = q;
  }
  /// The length that the coordinates have gone.
  double path() const { return path_; }
  /// What the values are not below, short of computing them.
  Vector at_least() const { return seen_ - speed_.cwiseProduct((path_ - seen_at_.array()).matrix()); }
  double value(std::ptrdiff_t i) {
    std::int64_t& seen_in = seen_in_[static_cast<std::size_t>(i)];
    if (seen_in != moves_) {
      seen_[i] = rest_[i] + inner_product(rows_.col(i).data(), q_.data(), q_.size());
      seen_at_[i] = path_;
      seen_in = moves_;
    }
    return seen_[i];
  }

 private:
  Vector rest_;
  Eigen::MatrixXd rows_;               // (r, values)
  Vector speed_;                       // norms of these
  Vector seen_, seen_at_;              // values when last computed, and the path until then
  std::vector<std::int64_t> seen_in_;  // the move that was
  Vector q_;
  double path_ = 0.0;
  std::int64_t moves_ = 0;
};

}  // namespace plica

#include "plica/dynamics/clearance.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace plica {

namespace {

/// Node and the node that faces it on the other surface, by local numbers, those common to both left out; none
/// where the airway does not say along which direction they face each other.
std::vector<std::array<std::int32_t, 2>> facing_pairs(const Airway& airway, const Points& x) {
  std::vector<std::array<std::int32_t, 2>> pairs;
  if (airway.facing.isZero(0)) return pairs;
  std::vector<char> first(static_cast<std::size_t>(x.rows()), 0), second = first;
  for (const std::int32_t node : airway.first.reshaped()) first[static_cast<std::size_t>(node)] = 1;
  for (const std::int32_t node : airway.second.reshaped()) second[static_cast<std::size_t>(node)] = 1;
  std::vector<std::int32_t> partner(static_cast<std::size_t>(x.rows()), -1);
  const auto beside = [&](std::int32_t a, std::int32_t b) {
    const Vector3 apart = x.row(b) - x.row(a);
    return (apart - airway.facing.dot(apart) * airway.facing).norm();
  };
  for (const auto& tet : airway.tets.rowwise())
    for (const std::int32_t a : tet)
      for (const std::int32_t b : tet) {
        const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
        if (!first[i] || second[i] || !second[j] || first[j]) continue;
        if (partner[i] < 0 || beside(a, b) < beside(a, partner[i])) partner[i] = b;
      }
  for (std::int32_t a = 0; a < x.rows(); ++a)
    if (partner[static_cast<std::size_t>(a)] >= 0) pairs.push_back({a, partner[static_cast<std::size_t>(a)]});
  return pairs;
}

}  // namespace

Clearance::Clearance(const Airway& airway, const Points& x, const Eigen::MatrixXd& shapes, double mean_edge)
    : facing_(airway.facing), round_off_(1e-6F * static_cast<float>(mean_edge)) {
  const std::vector<std::array<std::int32_t, 2>> pairs = facing_pairs(airway, x);
  const auto count = static_cast<std::ptrdiff_t>(pairs.size());
  offsets_.resize(3 * count);
  shapes_.resize(3 * count, shapes.cols());
  for (std::ptrdiff_t p = 0; p < count; ++p) {
    const auto [a, b] = pairs[static_cast<std::size_t>(p)];
    offsets_.segment<3>(3 * p) = (x.row(b) - x.row(a)).transpose().cast<float>();
    shapes_.middleRows<3>(3 * p) = (shapes.middleRows<3>(3 * b) - shapes.middleRows<3>(3 * a)).cast<float>();
  }
  for (std::ptrdiff_t p = 0; p < count; ++p) {
    const Eigen::MatrixXd moves = shapes_.middleRows<3>(3 * p).cast<double>();
    const Eigen::RowVectorXd apart = facing_.transpose() * moves;
    speed_ = std::max(speed_, apart.norm() + 2 * (moves - facing_ * apart).norm());
  }
}

float Clearance::least(const Eigen::VectorXf& offsets) const {
  if (offsets.size() == 0) return -1.0F;
  const Eigen::Vector3f facing = facing_.cast<float>();
  float least = std::numeric_limits<float>::infinity();
  for (std::ptrdiff_t at = 0; at < offsets.size(); at += 3) {
    const float along = offsets_.segment<3>(at).dot(facing) < 0 ? -1.0F : 1.0F;
    const float apart = offsets.segment<3>(at).dot(facing);
    const float slid = (offsets.segment<3>(at) - apart * facing).norm();
    const float over = along * apart - 2 * slid - round_off_;
    least = over < least ? over : std::min(least, over);
    if (!(over > 0)) return over;
  }
  return least;
}

bool Clearance::apart(const Vector& q) {
  if (seen_ > 0 && 1.001 * speed_ * (q - seen_at_).norm() < seen_) return true;
  seen_at_ = q;
  seen_ = least(offsets(q));
  return seen_ > 0;
}

}  // namespace plica

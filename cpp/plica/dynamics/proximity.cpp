#include "plica/dynamics/proximity.hpp"

#include <algorithm>
#include <limits>

#include "plica/dynamics/modal_force_solver.hpp"

namespace plica {

namespace {

std::vector<std::vector<std::int32_t>> fans_of(const Triangles& triangles, std::ptrdiff_t nodes) {
  std::vector<std::vector<std::int32_t>> fans(static_cast<std::size_t>(nodes));
  for (std::int32_t t = 0; t < triangles.rows(); ++t)
    for (const std::int32_t node : triangles.row(t)) fans[static_cast<std::size_t>(node)].push_back(t);
  return fans;
}

double mean_edge(const Airway& airway, const Points& x) {
  return 0.5 * (ContactSurface(airway.first, x.rows()).mean_edge(x) +
                ContactSurface(airway.second, x.rows()).mean_edge(x));
}

}  // namespace

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

Proximity::Proximity(const Airway& airway, const Points& x, const Eigen::MatrixXd& shapes)
    : facing_(airway.facing),
      round_off_(1e-6F * static_cast<float>(mean_edge(airway, x))),
      sides_{Side{airway.first, fans_of(airway.first, x.rows())},
             Side{airway.second, fans_of(airway.second, x.rows())}},
      tets_(airway.tets),
      pairs_(facing_pairs(airway, x)),
      speed_(largest_displacements(shapes)),
      closing_speed_(Vector::Zero(shapes.cols())),
      near_pairs_(pairs_.size(), 0),
      near_(static_cast<std::size_t>(x.rows()), 0) {
  const auto count = static_cast<std::ptrdiff_t>(pairs_.size());
  offsets_.resize(3 * count);
  Eigen::MatrixXd moves(3 * count, shapes.cols());
  for (std::ptrdiff_t p = 0; p < count; ++p) {
    const auto [a, b] = pairs_[static_cast<std::size_t>(p)];
    offsets_.segment<3>(3 * p) = (x.row(b) - x.row(a)).transpose().cast<float>();
    moves.middleRows<3>(3 * p) = shapes.middleRows<3>(3 * b) - shapes.middleRows<3>(3 * a);
    const Eigen::RowVectorXd apart = facing_.transpose() * moves.middleRows<3>(3 * p);
    const Eigen::RowVectorXd slid = (moves.middleRows<3>(3 * p) - facing_ * apart).colwise().norm();
    closing_speed_ = closing_speed_.cwiseMax((apart.cwiseAbs() + 2 * slid).transpose());
  }
  shapes_ = SinglePanelMatrix(moves);
}

Eigen::VectorXf Proximity::gaps(const Vector& q) const {
  const Eigen::VectorXf offsets = offsets_ + shapes_ * Eigen::VectorXf(q.cast<float>());
  const Eigen::Vector3f facing = facing_.cast<float>();
  Eigen::VectorXf gaps(offsets.size() / 3);
  for (std::ptrdiff_t p = 0; p < gaps.size(); ++p) {
    const Eigen::Vector3f offset = offsets.segment<3>(3 * p);
    const float along = offsets_.segment<3>(3 * p).dot(facing) < 0 ? -1.0F : 1.0F;
    const float apart = offset.dot(facing);
    gaps[p] = along * apart - 2 * (offset - apart * facing).norm() - round_off_;
  }
  return gaps;
}

void Proximity::see(const Vector& q, const Eigen::VectorXf& gaps) {
  seen_at_ = q;
  left_ = apart_ = std::numeric_limits<double>::infinity();
  for (std::ptrdiff_t p = 0; p < gaps.size(); ++p) {
    double& least = near_pairs_[static_cast<std::size_t>(p)] ? apart_ : left_;
    if (!(gaps[p] >= least)) least = gaps[p];
  }
}

bool Proximity::holds_at(const Vector& q) {
  if (everything() || (left_ > 0 && 1.001 * closed(q - seen_at_) < left_)) return true;
  if (seen_at_.size() == 0) return false;
  see(q, gaps(q));
  return left_ > 0;
}

void Proximity::choose(const Vector& q, double ahead, const std::vector<std::int32_t>& touching) {
  if (everything()) return;
  const Eigen::VectorXf gaps = this->gaps(q);
  std::fill(near_.begin(), near_.end(), 0);
  for (const std::int32_t node : touching) near_[static_cast<std::size_t>(node)] = 1;
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    near_pairs_[p] = !(gaps[static_cast<std::ptrdiff_t>(p)] > ahead);
    if (near_pairs_[p])
      for (const std::int32_t node : pairs_[p]) near_[static_cast<std::size_t>(node)] = 1;
  }
  see(q, gaps);
  const std::vector<char> of_pairs = near_;
  air_.clear();
  for (std::int32_t t = 0; t < tets_.rows(); ++t) {
    const auto tet = tets_.row(t);
    const auto is_near = [&](std::int32_t node) { return of_pairs[static_cast<std::size_t>(node)] != 0; };
    if (std::none_of(tet.begin(), tet.end(), is_near)) continue;
    air_.push_back(t);
    for (const std::int32_t node : tet) near_[static_cast<std::size_t>(node)] = 1;
  }
}

std::vector<std::int32_t> Proximity::around(const Side& side, int rings) const {
  std::vector<char> taken(static_cast<std::size_t>(side.triangles.rows()), 0), reached(near_);
  for (int ring = 0; ring < rings; ++ring) {
    const std::vector<char> from = reached;
    for (std::size_t node = 0; node < from.size(); ++node)
      if (from[node])
        for (const std::int32_t t : side.fans[node]) {
          taken[static_cast<std::size_t>(t)] = 1;
          for (const std::int32_t corner : side.triangles.row(t)) reached[static_cast<std::size_t>(corner)] = 1;
        }
  }
  std::vector<std::int32_t> found;
  for (std::size_t t = 0; t < taken.size(); ++t)
    if (taken[t]) found.push_back(static_cast<std::int32_t>(t));
  return found;
}

Neighbourhood Proximity::surroundings(int rings) const {
  return {around(sides_[0], rings), around(sides_[1], rings), air_};
}

}  // namespace plica

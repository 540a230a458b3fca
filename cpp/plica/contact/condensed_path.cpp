#include <algorithm>
#include <map>

#include "plica/contact/path.hpp"
#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"

namespace plica {

namespace {

class CondensedPath final : public ContactPath {
 public:
  CondensedPath(const BlockMatrix& A, const Supports& supports, const Indices& nodes, const KrylovOptions& options)
      : compliance_(A, supports, nodes, options), local_(static_cast<std::size_t>(A.rows() / 3), -1) {
    for (std::int32_t i = 0; i < nodes.size(); ++i) local_[nodes[i]] = i;
  }

  Complementarity solve(const std::vector<Pair>& pairs, const LinearGaps& gaps, double scale,
                        std::vector<char> guess, double gap_tolerance, int most_pivots) override {
    touch(pairs);
    const auto rows = static_cast<std::ptrdiff_t>(pairs.size());
    // Column j of Y: displacement of the touched nodes under unit forces of pair j.
    Eigen::MatrixXd Y(3 * static_cast<std::ptrdiff_t>(touched_.size()), rows);
    for_chunks(rows, 16, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
      for (std::ptrdiff_t j = begin; j < end; ++j) response(pairs[j], Y.col(j));
    });
    Eigen::MatrixXd W(rows, rows);
    for (std::ptrdiff_t i = 0; i < rows; ++i) {
      const Pair& pair = pairs[i];
      const std::ptrdiff_t s = 3 * position_[local_[pair.slave]];
      const Vector3& direction = gaps.direction[static_cast<std::size_t>(i)];
      W.row(i).noalias() = scale * direction.transpose() * Y.middleRows<3>(s);
      for (int k = 0; k < 3; ++k)
        W.row(i).noalias() -= scale * pair.weights[k] * direction.transpose() *
                              Y.middleRows<3>(3 * position_[local_[pair.master[k]]]);
      if (pair.stiffness > 0) W(i, i) += 1.0 / pair.stiffness;
    }
    return solve_complementarity(W, gaps.free, std::move(guess), gap_tolerance, most_pivots);
  }

  void move(const std::vector<Pair>& pairs, const Vector& force, double scale, const Points& x_free,
            Points& x) override {
    const std::ptrdiff_t count = 3 * compliance_.nodes().size();
    std::map<std::int32_t, Vector3> nodal;  // ordered: the sum below has one order
    for (std::size_t j = 0; j < pairs.size(); ++j) {
      if (force[j] == 0.0) continue;
      nodal.try_emplace(local_[pairs[j].slave], Vector3::Zero()).first->second += force[j] * pairs[j].normal;
      for (int k = 0; k < 3; ++k)
        nodal.try_emplace(local_[pairs[j].master[k]], Vector3::Zero()).first->second -=
            force[j] * pairs[j].weights[k] * pairs[j].normal;
    }
    shift_.setZero(count);
    for_chunks(count, 512, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
      for (const auto& [node, f] : nodal)
        for (int c = 0; c < 3; ++c) {
          const double* column = compliance_.column(node, c);
          const double amount = scale * f[c];
          for (std::ptrdiff_t r = begin; r < end; ++r) shift_[r] += amount * column[r];
        }
    });
    const Indices& nodes = compliance_.nodes();
    for (std::ptrdiff_t i = 0; i < nodes.size(); ++i)
      x.row(nodes[i]) = x_free.row(nodes[i]) + shift_.segment<3>(3 * i).transpose();
  }

 private:
  /// Lists the nodes that the pairs touch and makes sure their columns exist.
  void touch(const std::vector<Pair>& pairs) {
    touched_.clear();
    for (const Pair& pair : pairs) {
      touched_.push_back(local_[pair.slave]);
      for (const std::int32_t node : pair.master) touched_.push_back(local_[node]);
    }
    std::sort(touched_.begin(), touched_.end());
    touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
    position_.assign(static_cast<std::size_t>(compliance_.nodes().size()), -1);
    for (std::size_t i = 0; i < touched_.size(); ++i) position_[touched_[i]] = static_cast<std::int32_t>(i);
    compliance_.require(touched_);
  }

  void response(const Pair& pair, Eigen::Ref<Vector> y) const {
    y.setZero();
    const auto add = [&](std::int32_t node, double weight) {
      for (int c = 0; c < 3; ++c) {
        const double* column = compliance_.column(local_[node], c);
        const double amount = weight * pair.normal[c];
        if (amount == 0.0) continue;
        for (std::size_t i = 0; i < touched_.size(); ++i)
          for (int r = 0; r < 3; ++r) y[3 * i + r] += amount * column[3 * touched_[i] + r];
      }
    };
    add(pair.slave, 1.0);
    for (int k = 0; k < 3; ++k) add(pair.master[k], -pair.weights[k]);
  }

  Compliance compliance_;
  std::vector<std::int32_t> local_;     // node of the mesh -> position in compliance_.nodes()
  std::vector<std::int32_t> touched_;   // positions in compliance_.nodes()
  std::vector<std::int32_t> position_;  // position in compliance_.nodes() -> position in touched_
  Vector shift_;
};

}  // namespace

std::unique_ptr<ContactPath> condensed_path(const BlockMatrix& A, const Supports& supports, const Indices& nodes,
                                            const KrylovOptions& options) {
  return std::make_unique<CondensedPath>(A, supports, nodes, options);
}

}  // namespace plica

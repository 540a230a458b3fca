#include <algorithm>
#include <map>

#include "plica/contact/force_solver.hpp"
#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"

namespace plica {

namespace {

class CondensedSolver final : public ForceSolver {
 public:
  CondensedSolver(const LinearSolver& A, const Supports& supports, const Indices& nodes)
      : compliance_(A, supports, nodes, A.tolerance_of_positions()),
        local_(static_cast<std::size_t>(supports.size() / 3), -1) {
    for (std::int32_t i = 0; i < nodes.size(); ++i) local_[nodes[i]] = i;
  }

  Complementarity solve(const std::vector<Row>& rows, double scale, std::vector<char> guess, double gap_tolerance,
                        int most_pivots) override {
    return solve_complementarity(compliance(rows, scale), free_gaps(rows), std::move(guess), gap_tolerance,
                                 most_pivots);
  }

  Eigen::MatrixXd compliance(const std::vector<Row>& rows, double scale) override {
    touch(rows);
    const auto count = static_cast<std::ptrdiff_t>(rows.size());
    // Column j of Y: displacement of the touched nodes under a unit force of row j.
    Eigen::MatrixXd Y(3 * static_cast<std::ptrdiff_t>(touched_.size()), count);
    for_chunks(count, 16, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
      for (std::ptrdiff_t j = begin; j < end; ++j) response(rows[static_cast<std::size_t>(j)], Y.col(j));
    });
    Eigen::MatrixXd W = Eigen::MatrixXd::Zero(count, count);
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const Row& row = rows[static_cast<std::size_t>(i)];
      for (const auto& [node, vector] : row.gap)
        W.row(i).noalias() += scale * vector.transpose() * Y.middleRows<3>(3 * position_[local_[node]]);
      W(i, i) += row.compliance;
    }
    return W;
  }

  void move(const std::vector<Row>& rows, const Vector& force, double scale, const Points& x_free,
            Points& x) override {
    find_shift(nodal_forces(rows, force), scale);
    const Indices& nodes = compliance_.nodes();
    for (std::ptrdiff_t i = 0; i < nodes.size(); ++i)
      x.row(nodes[i]) = x_free.row(nodes[i]) + shift_.segment<3>(3 * i).transpose();
  }

  void add_response(const Vector& force, Vector& a) const override {
    std::vector<Compliance::Force> nodal;
    for (const auto& [node, f] : nodal_forces(force)) nodal.push_back({node, f});
    compliance_.add_response(nodal, a);
  }

 private:
  /// Forces by position in compliance_.nodes(), N; ordered, so that sums over it have one order.
  using Nodal = std::map<std::int32_t, Vector3>;

  /// scale A^-1 of these forces at the nodes.
  void find_shift(const Nodal& nodal, double scale) {
    const std::ptrdiff_t count = 3 * compliance_.nodes().size();
    shift_.setZero(count);
    for_chunks(count, 512, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
      for (const auto& [node, f] : nodal)
        for (int c = 0; c < 3; ++c) {
          const double* column = compliance_.column(node, c);
          const double amount = scale * f[c];
          for (std::ptrdiff_t r = begin; r < end; ++r) shift_[r] += amount * column[r];
        }
    });
  }

  Nodal nodal_forces(const Vector& force) const {
    Nodal nodal;
    for (std::int32_t i = 0; i < compliance_.nodes().size(); ++i)
      if (const Vector3 f = force.segment<3>(3 * static_cast<std::ptrdiff_t>(compliance_.nodes()[i]));
          !f.isZero(0))
        nodal.emplace(i, f);
    return nodal;
  }

  Nodal nodal_forces(const std::vector<Row>& rows, const Vector& force) const {
    Nodal nodal;
    for (std::size_t j = 0; j < rows.size(); ++j) {
      const double p = force[static_cast<std::ptrdiff_t>(j)];
      if (p == 0.0) continue;
      for (const auto& [node, vector] : rows[j].push)
        nodal.try_emplace(local_[node], Vector3::Zero()).first->second += p * vector;
    }
    return nodal;
  }

  /// Lists the nodes that the rows touch and makes sure that the columns of those they push exist.
  void touch(const std::vector<Row>& rows) {
    std::vector<std::int32_t> pushed;
    touched_.clear();
    for (const Row& row : rows) {
      for (const auto& [node, vector] : row.push) pushed.push_back(local_[node]);
      for (const auto& [node, vector] : row.gap) touched_.push_back(local_[node]);
    }
    const auto ascending = [](std::vector<std::int32_t>& nodes) {
      std::sort(nodes.begin(), nodes.end());
      nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    };
    ascending(pushed);
    ascending(touched_);
    position_.assign(static_cast<std::size_t>(compliance_.nodes().size()), -1);
    for (std::size_t i = 0; i < touched_.size(); ++i) position_[touched_[i]] = static_cast<std::int32_t>(i);
    compliance_.require(pushed);
  }

  void response(const Row& row, Eigen::Ref<Vector> y) const {
    y.setZero();
    for (const auto& [node, vector] : row.push)
      for (int c = 0; c < 3; ++c) {
        const double amount = vector[c];
        if (amount == 0.0) continue;
        const double* column = compliance_.column(local_[node], c);
        for (std::size_t i = 0; i < touched_.size(); ++i)
          for (int r = 0; r < 3; ++r) y[3 * i + r] += amount * column[3 * touched_[i] + r];
      }
  }

  Compliance compliance_;
  std::vector<std::int32_t> local_;     // node of the mesh -> position in compliance_.nodes()
  std::vector<std::int32_t> touched_;   // positions in compliance_.nodes()
  std::vector<std::int32_t> position_;  // position in compliance_.nodes() -> position in touched_
  Vector shift_;
};

}  // namespace

std::unique_ptr<ForceSolver> condensed_solver(const LinearSolver& A, const Supports& supports,
                                              const Indices& nodes) {
  return std::make_unique<CondensedSolver>(A, supports, nodes);
}

}  // namespace plica

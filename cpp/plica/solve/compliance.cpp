#include "plica/solve/compliance.hpp"

#include <algorithm>

#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"

namespace plica {

Compliance::Compliance(const LinearSolver& A, const Supports& supports, Indices nodes, double tolerance)
    : supports_(supports),
      nodes_(std::move(nodes)),
      solver_(A),
      tolerance_(tolerance),
      unknowns_(supports.size()) {
  for (const std::int32_t node : nodes_) {
    if (node < 0 || node >= unknowns_ / 3) {
      throw InvalidInput("Compliance", "node", node, "",
                         "in [0, " + number_text(static_cast<double>(unknowns_ / 3)) + ")");
    }
  }
  columns_.resize(static_cast<std::size_t>(3 * nodes_.size()));
  responses_.resize(columns_.size());
}

void Compliance::check_local(std::int32_t local_node) const {
  if (local_node < 0 || local_node >= nodes_.size()) {
    throw InvalidInput("Compliance", "local_node", local_node, "",
                       "in [0, " + number_text(static_cast<double>(nodes_.size())) + ")",
                       "It is a position in nodes(), not a node number.");
  }
}

void Compliance::require(const std::vector<std::int32_t>& local_nodes) {
  std::vector<std::int32_t> missing;
  for (const std::int32_t local_node : local_nodes) {
    check_local(local_node);
    for (int c = 0; c < 3; ++c) {
      const std::int32_t column = 3 * local_node + c;
      if (columns_[static_cast<std::size_t>(column)].empty()) missing.push_back(column);
    }
  }
  std::sort(missing.begin(), missing.end());
  missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
  std::vector<std::int32_t> to_solve;
  for (const std::int32_t column : missing) {
    if (supports_.fixed(3 * static_cast<std::ptrdiff_t>(nodes_[column / 3]) + column % 3)) {
      columns_[static_cast<std::size_t>(column)].assign(columns_.size(), 0.0);
    } else {
      to_solve.push_back(column);
    }
  }
  for (std::size_t first = 0; first < to_solve.size(); first += batch) {
    const auto begin = to_solve.begin() + static_cast<std::ptrdiff_t>(first);
    const auto count = static_cast<std::ptrdiff_t>(std::min(batch, to_solve.size() - first));
    solve({begin, begin + count});
  }
}

void Compliance::solve(const std::vector<std::int32_t>& columns) {
  const auto count = static_cast<std::ptrdiff_t>(columns.size());
  Eigen::MatrixXd force = Eigen::MatrixXd::Zero(unknowns_, count), displacement;
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    const std::int32_t column = columns[static_cast<std::size_t>(k)];
    force(3 * static_cast<std::ptrdiff_t>(nodes_[column / 3]) + column % 3, k) = 1.0;
  }
  const std::vector<Convergence> ends = solver_.solve_many(force, displacement, tolerance_);
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    const std::int32_t column = columns[static_cast<std::size_t>(k)];
    const Convergence& end = ends[static_cast<std::size_t>(k)];
    if (!end.converged) {
      throw SolveFailed("Compliance: residual = " + number_text(end.residual) + " after " +
                        number_text(end.iterations) + " iterations under a unit force on node " +
                        number_text(nodes_[column / 3]) + " along " + "xyz"[column % 3] +
                        "; must be <= " + number_text(tolerance_) +
                        ". Raise max_iterations of solver.method, or use a factorisation for a step this large.");
    }
    std::vector<double>& values = columns_[static_cast<std::size_t>(column)];
    values.resize(columns_.size());
    for (std::ptrdiff_t i = 0; i < nodes_.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        values[static_cast<std::size_t>(3 * i + c)] =
            displacement(3 * static_cast<std::ptrdiff_t>(nodes_[i]) + c, k);
      }
    }
    Response& response = responses_[static_cast<std::size_t>(column)];
    const double least = farthest * displacement.col(k).cwiseAbs().maxCoeff();
    for (std::int32_t i = 0; i < unknowns_ / 3; ++i) {
      const Vector3 u = displacement.col(k).segment<3>(3 * static_cast<std::ptrdiff_t>(i));
      if (u.cwiseAbs().maxCoeff() < least) continue;
      response.node.push_back(i);
      response.value.push_back(u.cast<float>());
    }
    response.node.shrink_to_fit();
    response.value.shrink_to_fit();
  }
}

void Compliance::add_response(const std::vector<Force>& forces, Vector& a) const {
  for (const Force& force : forces) check_local(force.local_node);
  for_chunks(unknowns_ / 3, 1024, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    for (const Force& force : forces)
      for (int c = 0; c < 3; ++c) {
        if (force.force[c] == 0.0) continue;
        const Response& response = responses_[static_cast<std::size_t>(3 * force.local_node + c)];
        const auto first = std::lower_bound(response.node.begin(), response.node.end(), begin);
        for (auto i = static_cast<std::size_t>(first - response.node.begin());
             i < response.node.size() && response.node[i] < end; ++i)
          a.segment<3>(3 * static_cast<std::ptrdiff_t>(response.node[i])) +=
              force.force[c] * response.value[i].cast<double>();
      }
  });
}

const double* Compliance::column(std::int32_t local_node, int component) const {
  check_local(local_node);
  if (component < 0 || component > 2) throw InvalidInput("Compliance", "component", component, "", "in [0, 3)");
  const std::vector<double>& values = columns_[static_cast<std::size_t>(3 * local_node + component)];
  if (values.empty()) {
    throw InvalidInput("Compliance", "local_node", local_node, "", "one that was required before",
                       "Call require.");
  }
  return values.data();
}

}  // namespace plica

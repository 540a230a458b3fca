#include "plica/dynamics/pressure_response.hpp"

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"

namespace plica {

PressureResponse::PressureResponse(const Airflow& airflow, const Motion& motion, Indices nodes, bool ends)
    : images_(motion.images()),
      nodes_(std::move(nodes)),
      ends_(ends),
      least_rows_(nodes_.size() == 0 ? 0 : nodes_.maxCoeff() + std::ptrdiff_t{1}),
      own_(images_ ? images_->nodes_of(nodes_) : nodes_),
      place_(nodes_.size()) {
  require_indices("PressureResponse", "node", own_, motion.supports().size() / 3);
  const LinearSolver& A = motion.solver();
  const Supports& supports = motion.supports();
  const auto own = [&](std::int32_t node) { return images_ ? images_->node_of(node) : node; };
  std::vector<std::int32_t> place(static_cast<std::size_t>(supports.size() / 3), -1);
  for (std::int32_t i = 0; i < own_.size(); ++i) place[static_cast<std::size_t>(own_[i])] = i;
  for (std::ptrdiff_t i = 0; i < nodes_.size(); ++i) place_[i] = place[static_cast<std::size_t>(own(nodes_[i]))];
  const LoadPatterns& load_patterns = airflow.load_patterns();
  const auto& patterns = load_patterns.sections;  // rows: three a surface node
  const std::ptrdiff_t sections = patterns.cols() + (ends ? 2 : 0);
  at_nodes_.resize(3 * own_.size(), sections);
  everywhere_.resize(supports.size(), sections);
  for (std::ptrdiff_t first = 0; first < sections; first += LinearSolver::pack) {
    const std::ptrdiff_t count = std::min<std::ptrdiff_t>(LinearSolver::pack, sections - first);
    Eigen::MatrixXd load = Eigen::MatrixXd::Zero(supports.size(), count), response;
    for (std::ptrdiff_t row = 0; row < patterns.rows(); ++row) {
      const std::int32_t node = airflow.nodes()[row / 3];
      const std::ptrdiff_t unknown = 3 * static_cast<std::ptrdiff_t>(own(node)) + row % 3;
      const double sign = images_ ? images_->sign(node)[row % 3] : 1.0;
      if (supports.fixed(unknown)) continue;
      for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(patterns, row); entry; ++entry)
        if (entry.col() >= first && entry.col() < first + count)
          load(unknown, entry.col() - first) += sign * entry.value();
      for (int end = 0; ends && end < 2; ++end)
        if (const std::ptrdiff_t at = patterns.cols() + end - first; at >= 0 && at < count)
          load(unknown, at) += sign * (end == 0 ? load_patterns.below : load_patterns.above)[row];
    }
    for (const Convergence& end : A.solve_many(load, response, A.tolerance()))
      if (!end.converged)
        throw SolveFailed("Airflow: the response to a section's pressure stopped at residual " +
                          number_text(end.residual) + " after " + number_text(end.iterations) +
                          " iterations (tolerance " + number_text(A.tolerance()) +
                          "). Raise max_iterations of solver.method, cholesky or conjugate_gradients.");
    for (std::ptrdiff_t i = 0; i < own_.size(); ++i)
      at_nodes_.block(3 * i, first, 3, count) = response.middleRows<3>(3 * static_cast<std::ptrdiff_t>(own_[i]));
    everywhere_.middleCols(first, count) = response.cast<float>();
  }
}

Vector PressureResponse::difference(const AirwayPressure& one, const AirwayPressure& other) const {
  return ends_ ? Vector(one.all() - other.all()) : Vector(one.sections - other.sections);
}

void PressureResponse::displace(const Vector& pressure, double scale, Points& x) const {
  require_size("PressureResponse", "pressure", pressure.size(), at_nodes_.cols());
  require_at_least("PressureResponse", "x", x.rows(), least_rows_);
  const Vector amount = scale * pressure;
  Vector shift(at_nodes_.rows());
  for_chunks(own_.size(), 512, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    shift.segment(3 * begin, 3 * (end - begin)) = at_nodes_.middleRows(3 * begin, 3 * (end - begin)) * amount;
  });
  for (std::ptrdiff_t i = 0; i < nodes_.size(); ++i) {
    const Vector3 own = shift.segment<3>(3 * static_cast<std::ptrdiff_t>(place_[i]));
    x.row(nodes_[i]) += (images_ ? Vector3(images_->sign(nodes_[i]).cwiseProduct(own)) : own).transpose();
  }
}

void PressureResponse::add(const Vector& pressure, Vector& a) const {
  require_size("PressureResponse", "pressure", pressure.size(), everywhere_.cols());
  require_size("PressureResponse", "a", a.size(), everywhere_.rows());
  for_slices(a.size(), [&](std::ptrdiff_t at, std::ptrdiff_t count) {
    for (std::ptrdiff_t s = 0; s < pressure.size(); ++s)
      a.segment(at, count) += pressure[s] * everywhere_.col(s).segment(at, count).cast<double>();
  });
}

}  // namespace plica

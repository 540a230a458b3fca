#include "plica/dynamics/modal_force_solver.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace plica {

namespace {

/// Adds p times the rows (3 m, r) of these vectors at nodes.
template <class Rows>
void add(const Rows& of_nodes, const std::vector<NodeVector>& vectors, double p, Vector& sum) {
  for (const auto& [node, vector] : vectors)
    for (int c = 0; c < 3; ++c)
      if (vector[c] != 0)
        sum += p * vector[c] * of_nodes.row(3 * static_cast<std::ptrdiff_t>(node) + c).transpose();
}

}  // namespace

Vector largest_displacements(const Eigen::MatrixXd& shapes) {
  Vector largest = Vector::Zero(shapes.cols());
  for (std::ptrdiff_t k = 0; k < shapes.cols(); ++k)
    for (std::ptrdiff_t row = 0; row + 2 < shapes.rows(); row += 3)
      largest[k] = std::max(largest[k], shapes.col(k).segment<3>(row).norm());
  return largest;
}

MovedNodes::MovedNodes(Indices nodes, const RowMajorMatrix& shapes) : nodes_(std::move(nodes)) {
  Indices rows(3 * nodes_.size());
  for (std::ptrdiff_t i = 0; i < rows.size(); ++i) rows[i] = 3 * nodes_[i / 3] + static_cast<std::int32_t>(i % 3);
  panels_ = PanelMatrix(shapes, rows);
  single_panels_ = SinglePanelMatrix(shapes, rows);
}

void MovedNodes::move(const Points& from, const Vector& change, Points& x) const {
  const Vector moved = panels_ * change;
  for (std::ptrdiff_t i = 0; i < nodes_.size(); ++i)
    x.row(nodes_[i]) = from.row(nodes_[i]) + moved.segment<3>(3 * i).transpose();
}

void MovedNodes::move_single(const Points& from, const Vector& change, Points& x) const {
  const Eigen::VectorXf moved = single_panels_ * Eigen::VectorXf(change.cast<float>());
  for (std::ptrdiff_t i = 0; i < nodes_.size(); ++i)
    x.row(nodes_[i]) = from.row(nodes_[i]) + moved.segment<3>(3 * i).transpose().cast<double>();
}

ModalForceSolver::ModalForceSolver(const ModalMotion& motion, const RowMajorMatrix& shapes, bool single)
    : motion_(motion),
      shapes_(shapes),
      root_(shapes * Eigen::MatrixXd(motion.inverse().llt().matrixL())),
      largest_(largest_displacements(shapes)),
      single_(single),
      load_(Vector::Zero(motion.size())),
      acceleration_(load_) {}

Complementarity ModalForceSolver::solve(const std::vector<Row>& rows, double scale, std::vector<char> guess,
                                        double gap_tolerance, int most_pivots) {
  return solve_complementarity(compliance(rows, scale), free_gaps(rows), std::move(guess), gap_tolerance,
                               most_pivots);
}

Eigen::MatrixXd ModalForceSolver::compliance(const std::vector<Row>& rows, double scale) {
  const auto count = static_cast<std::ptrdiff_t>(rows.size());
  Eigen::MatrixXd push(root_.cols(), count), gap(root_.cols(), count);
  Vector sum;
  for (std::ptrdiff_t j = 0; j < count; ++j) {
    add(root_, rows[static_cast<std::size_t>(j)].push, 1.0, sum.setZero(root_.cols()));
    push.col(j) = sum;
    add(root_, rows[static_cast<std::size_t>(j)].gap, 1.0, sum.setZero(root_.cols()));
    gap.col(j) = sum;
  }
  Eigen::MatrixXd W = scale * gap.transpose() * push;
  for (std::ptrdiff_t i = 0; i < count; ++i) W(i, i) += rows[static_cast<std::size_t>(i)].compliance;
  return W;
}

void ModalForceSolver::respond(const std::vector<Row>& rows, const Vector& force) {
  load_.setZero();
  for (std::size_t j = 0; j < rows.size(); ++j)
    if (const double p = force[static_cast<std::ptrdiff_t>(j)]; p != 0) add(shapes_, rows[j].push, p, load_);
  motion_.solve(load_, acceleration_);
}

void ModalForceSolver::move(const std::vector<Row>& rows, const Vector& force, double scale, const Points& x_free,
                            Points& x) {
  respond(rows, force);
  shifted_ = scale * largest_.dot(acceleration_.cwiseAbs());
  farthest_shift_ = std::max(farthest_shift_, shifted_);
  if (single_)
    seen_->move_single(x_free, scale * acceleration_, x);
  else
    seen_->move(x_free, scale * acceleration_, x);
}

}  // namespace plica

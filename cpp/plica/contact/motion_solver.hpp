#pragma once
#include <vector>

#include "plica/contact/force_solver.hpp"

namespace plica {

/// What solvers have in common that find the forces of an active set together with the motion of all unknowns.
class MotionSolver : public ForceSolver {
 public:
  void move(const std::vector<Row>&, const Vector&, double scale, const Points& x_free, Points& x) override {
    for (std::ptrdiff_t i = 0; i < nodes_.size(); ++i)
      x.row(nodes_[i]) = x_free.row(nodes_[i]) + scale * change_.segment<3>(3 * nodes_[i]).transpose();
  }
  void add_response(const Vector&, Vector& a) const override { a += change_; }

 protected:
  /// `supports` must outlive it.
  MotionSolver(std::ptrdiff_t unknowns, const Supports& supports, const Indices& nodes)
      : change_(Vector::Zero(unknowns)), supports_(supports), nodes_(nodes) {}

  /// The rows as unknowns that are not held see them.
  std::vector<Row> not_held(const std::vector<Row>& rows) const { return without_held(rows, supports_); }
  /// w (rows) m: the gaps under change_ of rows that are not active, 0 of those that are.
  void set_gaps(const std::vector<Row>& rows, const std::vector<Row>& not_held, const std::vector<char>& active,
                double scale, Vector& w) const {
    for (std::size_t i = 0; i < active.size(); ++i)
      w[static_cast<std::ptrdiff_t>(i)] = active[i] ? 0.0 : rows[i].free + scale * not_held[i].along(change_);
  }

  Vector change_;  // (3 n) a - a_free of the last active set

 private:
  const Supports& supports_;
  Indices nodes_;
};

}  // namespace plica

#pragma once
#include <Eigen/Cholesky>

#include "plica/contact/complementarity.hpp"
#include "plica/dynamics/mirrored_side.hpp"
#include "plica/dynamics/reduced_contact.hpp"

namespace plica {

/// The contact of a fold with its own mirror image in x = 0. A node behind the image's surface is behind the
/// plane, and the forces that keep both apart are along x: gaps are x >= 0 of the part's nodes, linear in the
/// coordinates, and nothing has to be detected (docs/theory/symmetry.md, "Contact of mirror images").
class MirrorContact final : public ReducedContact {
 public:
  /// See reduced_contact; the scene has a symmetry.
  MirrorContact(const Scene& scene, const Motion& full, const ModalMotion& motion, const Mediolateral& positions);

  void begin(const State& last) override;
  void touch(const FreeEnd& free) override;
  const Vector& x_acceleration() const override { return x_acceleration_; }
  Vector load() const override { return of_forces(loads_); }
  Vector acceleration() const override { return of_forces(accelerations_); }
  Vector interface_force() const override;
  std::pair<std::vector<std::int32_t>, Vector> closed() const override;
  bool knows(std::int32_t key) const override { return key >= 0 && key < nodes_.size(); }
  bool anywhere(const std::function<bool(const Vector3&)>& place) const override;
  ContactRecord record(const State& now) override;
  void restore(const State& state) override;
  Vector pressure() const override;
  Vector force(const Vector& interface_force) const override;
  void require_open_beyond(const State&, const Points&) override {}  // it looks everywhere

 private:
  /// Adds those rows whose x (m) is below -least (m).
  bool add_candidates(const Vector& x, double least);
  Complementarity solve(const Vector& x);
  /// What the forces make of columns (any, rows) of 1 N.
  Vector of_forces(const Eigen::MatrixXd& columns) const;
  double inertia() const { return motion_.scheme().inertia(motion_.step()); }

  // A row is one of nodes(), its x and the force along it.
  const ModalMotion& motion_;
  const MirrorImages& images_;
  std::ptrdiff_t mesh_nodes_;
  MirroredSide side_;
  double tolerance_;               // m, of gaps
  Vector copies_;                  // (rows) how many nodes each moves with it, itself included
  Eigen::MatrixXd loads_;          // (r, rows) Phi^T of 1 N on a row's node and its images
  Eigen::MatrixXd accelerations_;  // (r, rows) A^-1 of these
  Eigen::MatrixXd compliance_;     // (rows, rows) m/N, sqrt(c_i) h^2 beta (X A^-1 X^T)_ij sqrt(c_j), c the copies
  double least_compliance_;        // m/N, added to the diagonal
  std::vector<std::int32_t> factored_;  // closed rows
  Eigen::LLT<Eigen::MatrixXd> factor_;  // of their compliance
  Eigen::MatrixXd x_accelerations_;     // (n, rows) 1/kg, that of all of Mediolateral's nodes
  std::vector<PressedNode> pressed_;    // of the last record

  // Of the step.
  Vector x_acceleration_;           // (n) m/s^2 of the last move, where it touches
  const FreeEnd* free_ = nullptr;   // of the last move
  double deepest_ = 0.0;            // m, <= 0: least x with contact
  std::vector<std::int32_t> rows_;  // candidates, ascending
  std::vector<char> active_;        // of these
  Vector row_force_;                // (rows) N
  int passes_ = 0, pivots_ = 0;
};

}  // namespace plica

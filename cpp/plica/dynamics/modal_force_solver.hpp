#pragma once
#include "plica/contact/force_solver.hpp"
#include "plica/dynamics/modal_motion.hpp"

namespace plica {

/// Some nodes of a contact, by their numbers in it, and what coordinates move them by.
class MovedNodes {
 public:
  MovedNodes() = default;
  /// shapes (3 m, r) of all nodes.
  MovedNodes(Indices nodes, const RowMajorMatrix& shapes);

  const Indices& nodes() const { return nodes_; }
  /// x (m, 3) at these nodes: what a change of the coordinates makes of `from`.
  void move(const Points& from, const Vector& change, Points& x) const;
  /// The same in single precision, with an error of 6e-8 of the displacement.
  void move_single(const Points& from, const Vector& change, Points& x) const;

 private:
  Indices nodes_;
  PanelMatrix panels_;
  SinglePanelMatrix single_panels_;
};

/// Contact forces and what they move in the coordinates of a reduced motion: A^-1 = L L^T is small and known, so a
/// row j is the vector L^T Phi^T n_j of r numbers, the compliance of the rows is the products of these, and
/// nothing is kept of nodes that touched before. Positions follow at the nodes looked at alone.
class ModalForceSolver final : public ForceSolver {
 public:
  /// shapes (3 m, r) of the contact's nodes, rows of held components zero. `single`: displacements by contact
  /// within a step are needed in single precision only. Motion and shapes must outlive it.
  ModalForceSolver(const ModalMotion& motion, const RowMajorMatrix& shapes, bool single);

  /// From now on moves these nodes alone, which must live until the next look.
  void look_at(const MovedNodes& nodes) { seen_ = &nodes; }
  /// A step's moves begin, of which farthest_shift() is the largest.
  void begin() { farthest_shift_ = 0.0; }

  Complementarity solve(const std::vector<Row>& rows, double scale, std::vector<char> guess, double gap_tolerance,
                        int most_pivots) override;
  Eigen::MatrixXd compliance(const std::vector<Row>& rows, double scale) override;
  void move(const std::vector<Row>& rows, const Vector& force, double scale, const Points& x_free,
            Points& x) override;
  double shifted() const override { return shifted_; }
  double farthest_shift() const { return farthest_shift_; }  // m
  /// Takes up the forces p of these rows, as move() does.
  void respond(const std::vector<Row>& rows, const Vector& force);
  // (r) Phi^T N^T p of the forces last taken up, and A^-1 of that.
  const Vector& load() const { return load_; }
  const Vector& acceleration() const { return acceleration_; }

 private:
  const ModalMotion& motion_;
  const RowMajorMatrix& shapes_;  // (3 m, r) Phi
  RowMajorMatrix root_;           // (3 m, r) Phi L
  Vector largest_;                // (r) largest displacement of a node in each coordinate
  bool single_;
  const MovedNodes* seen_ = nullptr;
  Vector load_, acceleration_;
  double shifted_ = 0.0, farthest_shift_ = 0.0;
};

/// (r) The largest displacement of a node in each coordinate: of shapes (3 m, r).
Vector largest_displacements(const Eigen::MatrixXd& shapes);

}  // namespace plica

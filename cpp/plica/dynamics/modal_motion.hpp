#pragma once
#include "plica/core/panel_matrix.hpp"
#include "plica/dynamics/last_basis.hpp"
#include "plica/dynamics/motion.hpp"

namespace plica {

/// The motion of a scene within a basis of displacements: u = Phi q with Phi^T M Phi = 1 and Phi^T K Phi diagonal,
/// of which M q.. + C q. + K q = Phi^T f is what is left (Galerkin). Vectors are of the r coordinates. Of a
/// symmetric scene Phi has the unknowns of its part, all nodes move by S Phi q (MirrorImages).
class ModalMotion {
 public:
  /// vectors (unknowns, any number): a basis, in whatever order and scale, of which held unknowns are taken out
  /// and directions that repeat others to 1e-6 are left out. With a damping ratio zeta in place of the motion's
  /// viscosity C is diagonal, 2 zeta sqrt(k) of each coordinate of the stiffness k. With `last` the basis of the
  /// scene before is taken where it is the same. Throws InvalidInput where nothing is left.
  ModalMotion(const Motion& motion, const Eigen::MatrixXd& vectors, std::optional<double> damping_ratio = {},
              LastBasis* last = nullptr);

  std::ptrdiff_t size() const { return stiffness_.size(); }
  const Eigen::MatrixXd& shapes() const { return shapes_; }  // (unknowns, r)
  /// The rows of S Phi of these nodes of the mesh, (3 nodes, r).
  Eigen::MatrixXd shapes_at(const Indices& nodes) const;
  const Vector& stiffness() const { return stiffness_; }  // (r) 1/s^2, ascending
  bool has_viscosity() const { return viscosity_.size() > 0; }
  const SchemeCoefficients& scheme() const { return scheme_; }
  double step() const { return step_; }
  const Start& start() const { return start_; }

  /// Phi^T f of forces on the unknowns.
  Vector forces(const Vector& force) const { return shapes_.transpose() * force; }
  /// Phi q (unknowns).
  Vector at_unknowns(const Vector& q) const { return shape_panels_ * q; }
  /// The coordinates of the field (unknowns) that is nearest, in the norm of the mass.
  Vector nearest(const Vector& field) const { return momenta_.transpose() * field; }
  auto elastic(const Vector& q) const { return stiffness_.cwiseProduct(q); }  // K q, an expression of q
  /// Empty where nothing is damped.
  Vector viscous(const Vector& v) const { return has_viscosity() ? Vector(viscosity_ * v) : Vector(); }
  /// A^-1 f, A = 1 + (1+alpha) gamma h C + (1+alpha) beta h^2 K.
  Vector solve(const Vector& force) const { return inverse_panels_ * force; }
  void solve(const Vector& force, Vector& a) const { inverse_panels_.multiply(force, a); }
  const Eigen::MatrixXd& inverse() const { return inverse_; }
  /// C a of a = A^-1 f, without a product; where something is damped.
  void viscous_of(const Vector& a, const Vector& force, Vector& found) const;

  /// As Motion::begin; displacement, velocity and load are of the coordinates.
  void begin(State& state);

 private:
  Eigen::MatrixXd step_matrix(double c, double k) const;

  SchemeCoefficients scheme_;
  double step_;
  const MirrorImages* images_;        // null where all nodes move on their own
  Eigen::MatrixXd shapes_, momenta_;  // (unknowns, r) Phi, M Phi
  Vector stiffness_;
  Eigen::MatrixXd viscosity_, inverse_;        // (r, r)
  PanelMatrix shape_panels_, inverse_panels_;  // for products
  Start start_;
};

}  // namespace plica

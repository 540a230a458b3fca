#include "plica/dynamics/modal_motion.hpp"

#include <Eigen/Cholesky>
#include <memory>

#include "plica/core/eigenpairs.hpp"
#include "plica/core/error.hpp"
#include "plica/dynamics/state.hpp"

namespace plica {

namespace {

Eigen::MatrixXd symmetric(const Eigen::MatrixXd& A) { return 0.5 * (A + A.transpose()); }

}  // namespace

ModalMotion::ModalMotion(const Motion& motion, const Eigen::MatrixXd& vectors, std::optional<double> damping_ratio,
                         LastBasis* last)
    : scheme_(motion.scheme()), step_(motion.step()), images_(motion.images()) {
  Eigen::MatrixXd basis = vectors;
  for (std::ptrdiff_t i = 0; i < basis.rows(); ++i)
    if (motion.supports().fixed(i)) basis.row(i).setZero();
  basis = last ? last->orthonormal(motion.mass(), basis) : mass_orthonormal(motion.mass(), std::move(basis));
  const Eigenpairs ritz =
      symmetric_eigenpairs(symmetric(basis.transpose() * times_columns(motion.stiffness(), basis)));
  stiffness_ = ritz.values;
  shapes_ = basis * ritz.vectors;
  momenta_ = times_columns(motion.mass(), shapes_);
  if (damping_ratio)
    viscosity_ = Eigen::MatrixXd((2 * *damping_ratio * stiffness_.cwiseMax(0).cwiseSqrt()).asDiagonal());
  else if (motion.viscosity())
    viscosity_ = symmetric(shapes_.transpose() * times_columns(*motion.viscosity(), shapes_));
  const auto [alpha, beta, gamma] = scheme_;
  const Eigen::MatrixXd A = step_matrix((1 + alpha) * gamma * step_, (1 + alpha) * beta * step_ * step_);
  inverse_ = symmetric(A.llt().solve(Eigen::MatrixXd::Identity(size(), size())));
  shape_panels_ = PanelMatrix(shapes_);
  inverse_panels_ = PanelMatrix(inverse_);
}

Eigen::MatrixXd ModalMotion::shapes_at(const Indices& nodes) const {
  Eigen::MatrixXd rows(3 * nodes.size(), size());
  for (std::ptrdiff_t i = 0; i < nodes.size(); ++i) {
    const std::int32_t own = images_ ? images_->node_of(nodes[i]) : nodes[i];
    rows.middleRows<3>(3 * i) = shapes_.middleRows<3>(3 * static_cast<std::ptrdiff_t>(own));
    if (images_) rows.middleRows<3>(3 * i) = images_->sign(nodes[i]).asDiagonal() * rows.middleRows<3>(3 * i);
  }
  return rows;
}

Eigen::MatrixXd ModalMotion::step_matrix(double c, double k) const {
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(size(), size());
  A.diagonal() += k * stiffness_;
  if (has_viscosity()) A += c * viscosity_;
  return A;
}

void ModalMotion::viscous_of(const Vector& a, const Vector& force, Vector& found) const {
  const double c = (1 + scheme_.alpha) * scheme_.gamma * step_,
               k = (1 + scheme_.alpha) * scheme_.beta * step_ * step_;
  found = (force - a - k * elastic(a)) / c;
}

void ModalMotion::begin(State& state) {
  state.elastic_force = elastic(state.displacement);
  StartForces forces{state.load - state.elastic_force, Vector::Zero(size())};
  if (has_viscosity()) forces.viscous = -viscous(state.velocity);
  const StartSystem system{
      [this](double c, double k) {
        const auto factor = std::make_shared<const Eigen::LLT<Eigen::MatrixXd>>(step_matrix(c, k));
        return StartSystem::Solve([factor](const Vector& force) { return Vector(factor->solve(force)); });
      },
      [](const Vector& a) { return a; }};
  start_ = start_motion(scheme_, step_, system, forces);
  state.acceleration = start_.acceleration;
  state.weighted_elastic_force = elastic(state.displacement + start_.displacement);
  state.viscous_force = viscous(state.velocity + start_.velocity);
  state.inertial_force = state.acceleration;
  state.stiffness_velocity = elastic(state.velocity);
  state.stiffness_acceleration = elastic(state.acceleration);
  state.viscosity_velocity = viscous(state.velocity);
  state.viscosity_acceleration = viscous(state.acceleration);
}

}  // namespace plica

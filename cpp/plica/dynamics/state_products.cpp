#include "plica/dynamics/state_products.hpp"

#include <cmath>

#include "plica/core/error.hpp"
#include "plica/dynamics/modal_motion.hpp"

namespace plica {

namespace {

/// Of the terms of a product: 64 steps of round-off, and what vectors have lost since, stay far below it; a state
/// stored in single precision does not.
constexpr double round_off = 1e-8;

/// Sums of the columns of |A|, symmetric.
Vector sums(const BlockMatrix& A) {
  const NodePattern& pattern = *A.pattern();
  Vector found = Vector::Zero(A.rows());
  for (std::ptrdiff_t i = 0; i < pattern.rows(); ++i)
    for (std::ptrdiff_t e = pattern.row_start[static_cast<std::size_t>(i)];
         e < pattern.row_start[static_cast<std::size_t>(i) + 1]; ++e)
      for (std::ptrdiff_t k = 0; k < 9; ++k) found[3 * i + k / 3] += std::abs(A.block(e)[k]);
  return found;
}

Vector sums(const NodalMatrix& M) {
  const NodePattern& pattern = *M.pattern();
  Vector found = Vector::Zero(M.rows());
  for (std::ptrdiff_t i = 0; i < pattern.rows(); ++i)
    for (std::ptrdiff_t e = pattern.row_start[static_cast<std::size_t>(i)];
         e < pattern.row_start[static_cast<std::size_t>(i) + 1]; ++e)
      found.segment<3>(3 * i).array() += std::abs(M.values()[static_cast<std::size_t>(e)]);
  return found;
}

double terms(const Vector& sums, const Vector& x) { return sums.dot(x.cwiseAbs()); }

}  // namespace

StateProducts::StateProducts(const Motion& motion)
    : first_displacement_(motion.start().displacement),
      first_velocity_(motion.start().velocity),
      excess_(motion.excess()),
      alpha_(motion.scheme().alpha),
      step_(motion.step()),
      explicit_(motion.is_explicit()) {
  const auto of = [](const auto& A) { return Operator{[&A](const Vector& x) { return Vector(A * x); }, sums(A)}; };
  M_ = of(motion.mass());
  K_ = of(motion.stiffness());
  if (motion.viscosity()) C_ = of(*motion.viscosity());
  if (!explicit_) A_ = of(motion.step_matrix());
}

StateProducts::StateProducts(const ModalMotion& motion)
    : first_displacement_(motion.start().displacement),
      first_velocity_(motion.start().velocity),
      alpha_(motion.scheme().alpha),
      step_(motion.step()),
      reduced_(true) {
  M_ = {[](const Vector& x) { return x; }, Vector::Ones(motion.size())};
  K_ = {[&motion](const Vector& x) { return Vector(motion.elastic(x)); }, motion.stiffness().cwiseAbs()};
  if (!motion.has_viscosity()) return;
  Vector columns = Vector::Zero(motion.size());
  for (std::ptrdiff_t j = 0; j < motion.size(); ++j)
    columns[j] = motion.viscous(Vector::Unit(motion.size(), j)).cwiseAbs().sum();
  C_ = {[&motion](const Vector& x) { return motion.viscous(x); }, columns};
  const auto [alpha, beta, gamma] = motion.scheme();
  inertia_ = (1 + alpha) * beta * step_ * step_;
  inverse_damping_ = 1 / ((1 + alpha) * gamma * step_);
}

void StateProducts::require_product(const char* name, const char* product, const Vector& stored, const Operator& A,
                                    const Vector& x, double magnitude) const {
  const Vector value = A.times(x);
  const double off = (stored - value).cwiseAbs().sum(), allowed = round_off * magnitude;
  if (off <= allowed) return;
  throw InvalidInput("Simulation", std::string("difference of the state's ") + name + " from " + product,
                     off / value.cwiseAbs().sum(), "of it", "round-off",
                     "A state whose displacement, velocity or acceleration was changed is restored as "
                     "restore(renewed(state)), which makes its products anew.");
}

void StateProducts::require_energy(const char* name, double stored, double value, double magnitude) const {
  if (std::abs(stored - value) <= round_off * magnitude) return;
  throw InvalidInput("Simulation", std::string("state's ") + name + " energy", stored, "J",
                     number_text(value) + ", that of its displacement and velocity",
                     "A state that was changed is restored as restore(renewed(state)), which counts the energy of "
                     "the change.");
}

void StateProducts::require(const State& state) const {
  require_products(state);
  // A velocity that strains nothing is in no product.
  const Vector &u = state.displacement, &v = state.velocity;
  require_energy("kinetic", state.ledger.kinetic, 0.5 * v.dot(M_.times(v)), 0.5 * M_.sums.dot(v.cwiseAbs2()));
  require_energy("elastic", state.ledger.elastic, excess_ ? excess_->energy(u) : 0.5 * u.dot(state.elastic_force),
                 0.5 * u.cwiseAbs2().dot(K_.sums) + 0.5 * u.cwiseAbs().dot(state.elastic_force.cwiseAbs()));
}

void StateProducts::require_products(const State& state) const {
  const Vector &u = state.displacement, &v = state.velocity, &a = state.acceleration;
  const double h = step_;
  const bool first = state.step == 0, unweighted = alpha_ == 0;
  // A product was carried on from the step before: what was there then may have cancelled since.
  const auto of = [&](const Operator& A, const Vector* x0, const Vector* x1, const Vector* x2) {
    return (x0 ? terms(A.sums, *x0) : 0) + (x1 ? h * terms(A.sums, *x1) : 0) +
           (x2 ? h * h * terms(A.sums, *x2) : 0);
  };
  const double K_u = of(K_, &u, &v, &a);
  require_product("elastic_force", "K u", state.elastic_force, K_, u, K_u);
  require_product("inertial_force", "M a", state.inertial_force, M_, a, of(M_, &a, nullptr, nullptr));
  const auto at_start = [&](const Vector& x, const Vector& shift) {
    return shift.size() > 0 ? Vector(x + shift) : x;
  };
  if (first || unweighted)
    require_product("weighted_elastic_force", "K U", state.weighted_elastic_force, K_,
                    first ? at_start(u, first_displacement_) : u,
                    K_u + (first && first_displacement_.size() > 0 ? terms(K_.sums, first_displacement_) : 0));
  double C_a = 0, C_v = 0;
  if (C_.times) {
    C_a = of(C_, &a, nullptr, nullptr);
    C_v = of(C_, &v, &a, nullptr);
    if (reduced_) {
      const double found = inverse_damping_ * (terms(M_.sums, a) + inertia_ * terms(K_.sums, a) +
                                               terms(M_.sums, state.load) + K_u + C_v);
      C_a += found;
      C_v += h * found;
    }
    if (first || (unweighted && !explicit_))
      require_product("viscous_force", "C V", state.viscous_force, C_, first ? at_start(v, first_velocity_) : v,
                      C_v + (first && first_velocity_.size() > 0 ? terms(C_.sums, first_velocity_) : 0));
  }
  if (explicit_) return;
  require_product("stiffness_velocity", "K v", state.stiffness_velocity, K_, v, of(K_, &v, &a, nullptr));
  require_product("stiffness_acceleration", "K a", state.stiffness_acceleration, K_, a,
                  of(K_, &a, nullptr, nullptr));
  if (C_.times) {
    require_product("viscosity_velocity", "C v", state.viscosity_velocity, C_, v, C_v);
    require_product("viscosity_acceleration", "C a", state.viscosity_acceleration, C_, a, C_a);
  }
  if (reduced_) return;
  if (state.past.accelerations.front() != a)
    throw InvalidInput(
        "Simulation: the first of the state's past accelerations is not its acceleration; must be. A state whose "
        "acceleration was changed is restored as restore(renewed(state)).");
  for (std::size_t k = 0; k < state.past.accelerations.size(); ++k) {
    const Vector& past = state.past.accelerations[k];
    require_product("past.images", "A a", state.past.images[k], A_, past, terms(A_.sums, past));
  }
}

State StateProducts::renewed(State state) const {
  const Vector &u = state.displacement, &v = state.velocity, &a = state.acceleration;
  const Vector elastic = K_.times(u);
  const bool first = state.step == 0;
  state.weighted_elastic_force =
      first && first_displacement_.size() > 0 ? K_.times(u + first_displacement_)
      : first || alpha_ == 0
          ? elastic
          : Vector(state.weighted_elastic_force + (1 + alpha_) * (elastic - state.elastic_force));
  state.elastic_force = elastic;
  state.inertial_force = M_.times(a);
  if (C_.times) {
    const Vector viscous = C_.times(v);
    state.viscous_force = first && first_velocity_.size() > 0 ? C_.times(v + first_velocity_)
                          : first || alpha_ == 0
                              ? viscous
                              : Vector(state.viscous_force + (1 + alpha_) * (viscous - state.viscosity_velocity));
    if (!explicit_) {
      state.viscosity_velocity = viscous;
      state.viscosity_acceleration = C_.times(a);
    }
  }
  if (!explicit_) {
    state.stiffness_velocity = K_.times(v);
    state.stiffness_acceleration = K_.times(a);
  }
  if (A_.times) {
    state.past = Past{};
    state.past.add(a, A_.times(a));
  }
  Ledger& ledger = state.ledger;
  const double before = ledger.kinetic + ledger.elastic;
  ledger.kinetic = 0.5 * v.dot(M_.times(v));
  ledger.elastic = 0.5 * u.dot(state.elastic_force);
  ledger.initial += ledger.kinetic + ledger.elastic - before;
  return state;
}

}  // namespace plica

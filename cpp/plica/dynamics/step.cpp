#include "plica/dynamics/step.hpp"

#include <algorithm>
#include <tuple>

#include "plica/core/stopwatch.hpp"
#include "plica/core/threads.hpp"
#include "plica/dynamics/scene_contact.hpp"
#include "plica/dynamics/scene_flow.hpp"

namespace plica {

Step::Step(const Motion& motion, const State& last, Vector scene_load, const Indices& seen, const SceneFlow* flow,
           SceneContact* contact, StepTimes& times)
    : motion_(motion),
      last_(last),
      seen_(seen),
      flow_(flow),
      contact_(contact),
      times_(times),
      scene_load_(std::move(scene_load)),
      x_previous_(motion.positions(last.displacement)),
      x_free_(x_previous_),
      x_(x_previous_),
      weighted_(x_previous_) {
  predict();
  if (motion_.excess()) begin_balance();
  if (contact_ == nullptr) return;
  const Stopwatch watch(times_.contact);
  contact_->begin(x_previous_, last_.depth);
}

void Step::predict() {
  const Stopwatch watch(times_.residual);
  const State& last = last_;
  const SchemeCoefficients& c = motion_.scheme();
  const double h = motion_.step(), weight = 1 + c.alpha;
  const double of_displacement = h * h * (0.5 - c.beta), of_velocity = h * (1 - c.gamma);
  const bool viscous = motion_.viscosity().has_value(), first = last.step == 0;
  const std::ptrdiff_t unknowns = last.displacement.size();
  for (Vector* v : {&displacement_predictor_, &velocity_predictor_, &elastic_predictor_, &inner_force_})
    v->resize(unknowns);
  if (viscous) viscous_predictor_.resize(unknowns);
  for_slices(unknowns, [&](std::ptrdiff_t at, std::ptrdiff_t count) {
    const auto part = [&](auto& v) { return v.segment(at, count); };
    part(displacement_predictor_) =
        part(last.displacement) + h * part(last.velocity) + of_displacement * part(last.acceleration);
    part(velocity_predictor_) = part(last.velocity) + of_velocity * part(last.acceleration);
    part(elastic_predictor_) = part(last.elastic_force) + h * part(last.stiffness_velocity) +
                               of_displacement * part(last.stiffness_acceleration);
    if (viscous)
      part(viscous_predictor_) = part(last.viscosity_velocity) + of_velocity * part(last.viscosity_acceleration);
  });
  if (first) {
    const Start& start = motion_.start();
    displacement_predictor_ += start.shift;
    elastic_predictor_ += motion_.stiffness() * start.shift;
    first_displacement_ = last.displacement + start.displacement;
    first_velocity_ = last.velocity + start.velocity;
  }
  const Vector &elastic = elastic_behind(), &damping = viscous_behind();
  for_slices(unknowns, [&](std::ptrdiff_t at, std::ptrdiff_t count) {
    const auto part = [&](auto& v) { return v.segment(at, count); };
    part(inner_force_) = c.alpha * part(elastic) - weight * part(elastic_predictor_);
    if (viscous) part(inner_force_) += c.alpha * part(damping) - weight * part(viscous_predictor_);
  });
  for (const std::int32_t node : seen_)
    weighted_.row(node) +=
        weight * (h * motion_.at(node, last.velocity) + 0.5 * h * h * motion_.at(node, last.acceleration));
}

void Step::begin_balance() {
  const Stopwatch watch(times_.tissue);
  const auto still = [this]() -> Guess {
    // U = u_n: (1 + alpha) (u~ + beta h^2 a) - alpha u_behind is the displacement of t_n.
    const double alpha = motion_.scheme().alpha, weight = 1 + alpha;
    const Vector u = (last_.displacement + alpha * displacement_behind()) / weight;
    Guess guess{(u - displacement_predictor_) / inertia(), Vector()};
    motion_.supports().project(guess.x);
    guess.product = motion_.image(motion_.products(guess.x));
    return guess;
  };
  tissue_.emplace(
      *motion_.excess(), [this](const Vector& a, Vector& U, Vector& V) { weigh(a, U, V); },
      Guess{last_.past.accelerations.front(), last_.past.images.front()}, still);
}

void Step::weigh(const Vector& a, Vector& U, Vector& V) const {
  const auto& [alpha, beta, gamma] = motion_.scheme();
  const double weight = 1 + alpha, rate = weight * gamma * motion_.step();
  U = weight * displacement_predictor_ + weight * inertia() * a - alpha * displacement_behind();
  if (motion_.viscosity()) V = weight * velocity_predictor_ + rate * a - alpha * velocity_behind();
}

void Step::move() {
  load_ = scene_load_;
  if (contact_ == nullptr && !tissue_) return;
  move_again();
}

void Step::move_again() {
  solve_free();
  take_positions();
  touch();
}

Vector Step::areas(Instant instant) const { return flow_->areas(at(instant)); }

AirwayExpansion Step::expansion(Instant instant) const {
  const auto& [alpha, beta, gamma] = motion_.scheme();
  const double h = motion_.step(), weight = motion_.scheme().weight();
  return flow_->expansion([&, alpha = alpha, gamma = gamma](std::int32_t node) -> Vector3 {
    const Vector3 before = motion_.at(node, last_.velocity);
    if (instant == Instant::last) return before;
    if (!moved_) return before + weight * h * motion_.at(node, last_.acceleration);
    const Vector3 u = x_.row(node).transpose() - motion_.reference().row(node).transpose();
    const Vector3 a = (u - motion_.at(node, displacement_predictor_)) / inertia();
    const Vector3 now = motion_.at(node, velocity_predictor_) + gamma * h * a;
    return weight * now - alpha * before;
  });
}

void Step::move(const AirwayPressure& pressure, Instant instant) {
  pressure_ = pressure;
  moved_ = true;
  if (!response_ || (!response_->ends() && !pressure.same_ends(solved_at_))) {
    take_load(instant);
    solve_free();
    response_ = flow_->response();
    solved_at_ = pressure;
  }
  {
    const Stopwatch watch(times_.load);
    take_positions();
  }
  touch();
}

void Step::take_load(Instant instant) {
  const Stopwatch watch(times_.load);
  load_ = scene_load_;
  flow_->add_load(at(instant), pressure_, load_);
}

void Step::solve_free() {
  const Stopwatch watch(times_.solve);
  // Where contact will add to it complete() has to go on from the sum.
  const LinearSolver& solver = motion_.solver();
  const Vector force = right_hand_side(Vector());
  if (free_.x.size() == 0) free_ = last_.past.nearest(force);
  iterations_ +=
      motion_.solve(force, free_, last_.closed.empty() ? solver.tolerance() : solver.tolerance_of_positions());
  for (const std::int32_t node : seen_)
    x_free_.row(node) =
        motion_.reference().row(node) +
        (motion_.at(node, displacement_predictor_) + inertia() * motion_.at(node, free_.x)).transpose();
}

void Step::take_positions() {
  for (const std::int32_t node : seen_) x_.row(node) = x_free_.row(node);
  if (response_) response_->displace(response_->difference(pressure_, solved_at_), inertia(), x_);
  take_weighted();
}

void Step::take_weighted() {
  const double alpha = motion_.scheme().alpha;
  for (const std::int32_t node : seen_)
    weighted_.row(node) = (1 + alpha) * x_.row(node) - alpha * x_previous_.row(node);
}

void Step::touch() {
  if (contact_ == nullptr) return;
  const Stopwatch watch(times_.contact);
  Points touching;
  contacts_ = contact_->solve(*this, std::move(contacts_), touching);
  x_ = std::move(touching);
  take_weighted();
}

bool Step::blocks() const { return contact_ && contact_->blocks(*flow_, contacts_, x_, x_previous_, last_.depth); }

Vector Step::right_hand_side(const Vector& contact_force) const {
  Vector force(load_.size());
  for_slices(force.size(), [&](std::ptrdiff_t at, std::ptrdiff_t count) {
    force.segment(at, count) = load_.segment(at, count) + inner_force_.segment(at, count);
    if (contact_force.size() > 0) force.segment(at, count) += contact_force.segment(at, count);
    if (tissue_) force.segment(at, count) -= tissue_->sum().segment(at, count);
  });
  motion_.supports().project(force);
  return force;
}

Vector Step::force_of_contacts() const {
  if (contact_ == nullptr) return {};
  Vector force = Vector::Zero(x_.size());
  if (contacts_.any_force()) contacts_.add_forces(force);
  return motion_.folded(std::move(force));
}

void Step::solve_anew() {
  if (!response_) return;
  if (const Vector more = response_->difference(pressure_, solved_at_); !more.isZero(0)) {
    response_->add(more, free_.x);
    free_.product.resize(0);
  }
  response_ = nullptr;
}

bool Step::retreat() {
  if (!tissue_) return false;
  const Stopwatch watch(times_.tissue);
  solve_anew();
  contacts_ = Contacts();
  return tissue_->retreat();
}

bool Step::settle() {
  if (!tissue_) return true;
  if (response_) take_load(Instant::weighted);
  const Vector contact_force = force_of_contacts();
  const Vector force = right_hand_side(contact_force);
  const Stopwatch watch(times_.tissue);
  solve_anew();
  Vector a = free_.x;
  if (contacts_.any_force()) contact_->collision().add_response(contact_force, a);
  return tissue_->settled({std::move(a), force});
}

void Step::complete() {
  contact_force_ = force_of_contacts();
  if (response_) take_load(Instant::weighted);
  const Stopwatch watch(times_.solve);
  const Vector force = right_hand_side(contact_force_);
  if (free_.x.size() == 0) {
    free_ = last_.past.nearest(force);
  } else {
    if (response_) response_->add(response_->difference(pressure_, solved_at_), free_.x);
    if (contacts_.any_force()) contact_->collision().add_response(contact_force_, free_.x);
    products_ = motion_.products(free_.x);
    free_.product = motion_.image(products_);
    if ((force - free_.product).norm() <= motion_.solver().tolerance() * force.norm()) return;
  }
  iterations_ += motion_.solve(force, free_, products_);
}

State Step::end() {
  const double alpha = motion_.scheme().alpha, gamma = motion_.scheme().gamma;
  const double h = motion_.step(), weight = 1 + alpha;
  const bool viscous = motion_.viscosity().has_value();
  const Vector& a = free_.x;
  State now;
  now.step = last_.step + 1;
  now.displacement = std::move(displacement_predictor_);
  now.velocity = std::move(velocity_predictor_);
  now.elastic_force = std::move(elastic_predictor_);
  now.viscosity_velocity = std::move(viscous_predictor_);
  now.stiffness_velocity.resize(a.size());
  for_slices(a.size(), [&](std::ptrdiff_t at, std::ptrdiff_t count) {
    const auto part = [&](auto& v) { return v.segment(at, count); };
    part(now.displacement) += inertia() * part(a);
    part(now.velocity) += gamma * h * part(a);
    part(now.elastic_force) += inertia() * part(products_.elastic);
    part(now.stiffness_velocity) = part(last_.stiffness_velocity) +
                                   h * (1 - gamma) * part(last_.stiffness_acceleration) +
                                   gamma * h * part(products_.elastic);
    if (viscous) part(now.viscosity_velocity) += gamma * h * part(products_.viscous);
  });
  if (last_.step == 0 || now.step % steps_between_products == 0) {
    now.elastic_force = motion_.stiffness() * now.displacement;
    now.stiffness_velocity = motion_.stiffness() * now.velocity;
    if (viscous) now.viscosity_velocity = *motion_.viscosity() * now.velocity;
  }
  const Vector &elastic = elastic_behind(), &damping = viscous_behind();
  now.weighted_elastic_force.resize(a.size());
  if (viscous) now.viscous_force.resize(a.size());
  for_slices(a.size(), [&](std::ptrdiff_t at, std::ptrdiff_t count) {
    const auto part = [&](auto& v) { return v.segment(at, count); };
    part(now.weighted_elastic_force) = weight * part(now.elastic_force) - alpha * part(elastic);
    if (viscous) part(now.viscous_force) = weight * part(now.viscosity_velocity) - alpha * part(damping);
  });
  now.inertial_force = std::move(products_.inertial);
  now.stiffness_acceleration = std::move(products_.elastic);
  now.viscosity_acceleration = std::move(products_.viscous);
  now.acceleration = std::move(free_.x);
  image_ = std::move(free_.product);
  if (tissue_) {
    now.elastic_excess = tissue_->force().elastic;
    now.viscous_excess = tissue_->force().viscous;
  }
  now.load = std::move(load_);
  now.contact_force = std::move(contact_force_);
  std::tie(now.closed, now.closed_force) = contacts_.closed();
  now.ledger = last_.ledger;
  now.first_signs = last_.first_signs;
  return now;
}

}  // namespace plica

#include "plica/dynamics/reduced_step.hpp"

#include <tuple>

#include "plica/core/stopwatch.hpp"

namespace plica {

void ReducedStep::begin(const State& last, const Vector& scene_load, const AirwayPressure& ends,
                        StepTimes& times) {
  last_ = &last;
  times_ = &times;
  scene_load_ = scene_load;
  ends_of_free_ = {ends.below, {}, ends.above};
  moving_.resize(0);
  expansions_.reset();
  predict();
  if (contact_) contact_->begin(last);
  solve_without();
}

void ReducedStep::predict() {
  const Stopwatch watch(times_->residual);
  const auto [alpha, beta, gamma] = motion_.scheme();
  const double h = motion_.step();
  const State& last = *last_;
  const bool first = last.step == 0;
  displacement_predictor_ = last.displacement + h * last.velocity + h * h * (0.5 - beta) * last.acceleration;
  velocity_predictor_ = last.velocity + h * (1 - gamma) * last.acceleration;
  if (first) displacement_predictor_ += motion_.start().shift;
  elastic_behind_ = first ? last.weighted_elastic_force : last.elastic_force;
  inner_force_ = alpha * elastic_behind_ - (1 + alpha) * motion_.elastic(displacement_predictor_);
  if (motion_.has_viscosity()) {
    viscous_predictor_ = last.viscosity_velocity + h * (1 - gamma) * last.viscosity_acceleration;
    viscous_behind_ = first ? last.viscous_force : last.viscosity_velocity;
    inner_force_ += alpha * viscous_behind_ - (1 + alpha) * viscous_predictor_;
  }
}

Vector ReducedStep::load_of_ends(const AirwayPressure& ends) const {
  Vector load = ends.below * flow_->load_below();
  if (ends.above != 0) load += ends.above * flow_->load_above();
  return load;
}

void ReducedStep::solve_without() {
  const Stopwatch watch(times_->solve);
  const double h = motion_.step(), alpha = motion_.scheme().alpha;
  force_ = scene_load_ + inner_force_;
  if (flow_) {
    force_ += load_of_ends(ends_of_free_);
  }
  motion_.solve(force_, free_);
  end_ = displacement_predictor_ + inertia() * free_;
  if (contact_) free_contact_x_ = positions_.contact_at(end_);
  if (!flow_) return;
  const State& last = *last_;
  ends_.resize(end_.size(), 2);
  ends_.col(0) = last.displacement + (1 + alpha) * (h * last.velocity + 0.5 * h * h * last.acceleration);
  ends_.col(1) = (1 + alpha) * end_ - alpha * last.displacement;
  const TwoColumns x = positions_.at(ends_);
  weighted_x_ = x.col(0);
  free_weighted_x_ = x.col(1);
}

void ReducedStep::move() {
  contact_x_ = free_contact_x_;
  touch();
}

void ReducedStep::move(const AirwayPressure& pressure, Instant) {
  {
    const Stopwatch watch(times_->solve);
    pressure_ = pressure;
    moving_ = flow_->moving(pressure, ends_of_free_);
    flow_->x_acceleration(moving_, x_acceleration_);
    weighted_x_ = free_weighted_x_ + weight() * inertia() * x_acceleration_.cast<double>();
    if (contact_)
      contact_x_ = free_contact_x_ + inertia() * x_acceleration_.head(free_contact_x_.size()).cast<double>();
  }
  touch();
}

void ReducedStep::touch() {
  if (contact_ == nullptr) return;
  const Stopwatch watch(times_->contact);
  contact_->touch(*this);
  if (flow_ && contact_->touches()) weighted_x_ += weight() * inertia() * contact_->x_acceleration();
}

Vector ReducedStep::free_acceleration() const {
  Vector acceleration = Vector::Zero(free_.size());
  if (moving_.size() > 0) flow_->acceleration(moving_, acceleration);
  return free_ + acceleration;
}

Vector ReducedStep::free_end() const { return displacement_predictor_ + inertia() * free_acceleration(); }

const std::array<AirwayExpansion, 2>& ReducedStep::expansions() const {
  if (expansions_) return *expansions_;
  const double h = motion_.step();
  TwoColumns velocities(free_.size(), 2);
  velocities.col(0) = last_->velocity + weight() * h * last_->acceleration;
  velocities.col(1) = weight() * (velocity_predictor_ + motion_.scheme().gamma * h * free_) -
                      motion_.scheme().alpha * last_->velocity;
  return expansions_.emplace(flow_->expansions(velocities));
}

AirwayExpansion ReducedStep::expansion(Instant at) const {
  if (at == Instant::last) return flow_->expansion(last_->velocity);
  if (moving_.size() == 0) return expansions()[0];
  const double grown = weight() * motion_.scheme().gamma * motion_.step();  // s, by an acceleration
  AirwayExpansion found = expansions()[1];
  flow_->add_expansion(grown, moving_, found);
  if (contact_ && contact_->touches()) {
    const AirwayExpansion pressed = flow_->expansion(grown * contact_->acceleration());
    found.sections += pressed.sections;
    found.below += pressed.below;
    found.above += pressed.above;
  }
  return found;
}

Vector ReducedStep::areas(Instant at) const {
  return flow_->areas(at == Instant::last ? positions_.at(last_->displacement) : weighted_x_);
}

bool ReducedStep::blocks() const {
  const Airflow& airflow = flow_->airflow();
  if (!airflow.stops_at_contact() || !contact_) return false;
  return contact_->anywhere(
      [&](const Vector3& x) { return airflow.blocks(x[1] + origin_[1], x[2] + origin_[2]); });
}

void ReducedStep::end(State& now) {
  const Stopwatch watch(times_->solve);
  const auto [alpha, beta, gamma] = motion_.scheme();
  const double h = motion_.step();
  now.step = last_->step + 1;
  Vector& a = now.acceleration;
  a = free_;
  now.load = scene_load_;
  if (flow_) {
    flow_->acceleration(moving_, acceleration_);
    a += acceleration_;
    flow_->load(pressure_.sections, now.flow_load);
    now.flow_load += load_of_ends(pressure_);
    now.load += now.flow_load;
  }
  if (contact_) {
    a += contact_->acceleration();
    now.contact_force = contact_->load();
    now.interface_force = contact_->interface_force();
    std::tie(now.closed, now.closed_force) = contact_->closed();
  }
  now.displacement = displacement_predictor_ + inertia() * a;
  now.velocity = velocity_predictor_ + gamma * h * a;
  now.elastic_force = motion_.elastic(now.displacement);
  now.weighted_elastic_force = (1 + alpha) * now.elastic_force - alpha * elastic_behind_;
  now.stiffness_velocity = motion_.elastic(now.velocity);
  now.stiffness_acceleration = motion_.elastic(a);
  if (motion_.has_viscosity()) {
    force_ = now.load + inner_force_;
    if (contact_) force_ += now.contact_force;
    motion_.viscous_of(a, force_, now.viscosity_acceleration);
    now.viscosity_velocity = viscous_predictor_ + gamma * h * now.viscosity_acceleration;
    if (last_->step == 0 || now.step % steps_between_products == 0)
      now.viscosity_velocity = motion_.viscous(now.velocity);
    now.viscous_force = (1 + alpha) * now.viscosity_velocity - alpha * viscous_behind_;
  }
  now.inertial_force = a;
  now.ledger = last_->ledger;
  now.first_signs = last_->first_signs;
}

}  // namespace plica

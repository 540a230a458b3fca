#include "plica/dynamics/reduced_step.hpp"

#include <tuple>

#include "plica/core/stopwatch.hpp"

namespace plica {

ReducedStep::ReducedStep(const ModalMotion& motion, const State& last, Vector scene_load, ReducedFlow* flow,
                         ReducedContact* contact, const Vector3& origin, StepTimes& times)
    : CoupledStep(last.flow_stopped),
      motion_(motion),
      last_(last),
      flow_(flow),
      contact_(contact),
      origin_(origin),
      times_(times),
      scene_load_(std::move(scene_load)) {
  const Stopwatch watch(times_.residual);
  const auto [alpha, beta, gamma] = motion.scheme();
  const double h = motion.step();
  const bool first = last.step == 0;
  displacement_predictor_ = last.displacement + h * last.velocity + h * h * (0.5 - beta) * last.acceleration;
  velocity_predictor_ = last.velocity + h * (1 - gamma) * last.acceleration;
  if (first) displacement_predictor_ += motion.start().shift;
  elastic_predictor_ = motion.elastic(displacement_predictor_);
  elastic_behind_ = first ? last.weighted_elastic_force : last.elastic_force;
  inner_force_ = alpha * elastic_behind_ - (1 + alpha) * elastic_predictor_;
  if (motion.has_viscosity()) {
    viscous_predictor_ = last.viscosity_velocity + h * (1 - gamma) * last.viscosity_acceleration;
    viscous_behind_ = first ? last.viscous_force : last.viscosity_velocity;
    inner_force_ += alpha * viscous_behind_ - (1 + alpha) * viscous_predictor_;
  }
  flow_load_ = Vector::Zero(motion.size());
  if (contact_) contact_->begin(last);
  end_ = last.displacement + h * last.velocity + 0.5 * h * h * last.acceleration;
}

void ReducedStep::move() {
  free_ = motion_.solve(scene_load_ + inner_force_);
  touch();
}

void ReducedStep::move(const Vector& pressure, Instant) {
  {
    const Stopwatch watch(times_.solve);
    if (solved_at_.size() == 0) {
      solved_at_ = pressure;
      flow_load_ = flow_->load(pressure);
      free_ = motion_.solve(scene_load_ + flow_load_ + inner_force_);
    } else {
      load_change_ = flow_->load_of(pressure - solved_at_);
      change_ = motion_.solve(load_change_);
    }
  }
  touch();
}

void ReducedStep::touch() {
  end_ = displacement_predictor_ + inertia() * free_;
  if (change_.size() > 0) end_ += inertia() * change_;
  if (contact_ == nullptr) return;
  const Stopwatch watch(times_.contact);
  contact_->touch(end_);
  if (contact_->touches()) end_ += inertia() * contact_->acceleration();
}

Vector ReducedStep::areas(Instant at) const {
  if (at == Instant::last) return flow_->areas(last_.displacement);
  return flow_->areas(weight() * end_ - motion_.scheme().alpha * last_.displacement);
}

bool ReducedStep::blocks() const {
  const Airflow& airflow = flow_->airflow();
  if (!airflow.stops_at_contact() || !contact_) return false;
  return contact_->anywhere(
      [&](const Vector3& x) { return airflow.blocks(x[1] + origin_[1], x[2] + origin_[2]); });
}

State ReducedStep::end() {
  constexpr int renewed = 64;  // steps after which round-off in the products is taken away
  const Stopwatch watch(times_.solve);
  const auto [alpha, beta, gamma] = motion_.scheme();
  const double h = motion_.step();
  State now;
  now.step = last_.step + 1;
  Vector a = free_;
  if (change_.size() > 0) {
    a += change_;
    flow_load_ += load_change_;
  }
  if (contact_) a += contact_->acceleration();
  now.load = scene_load_ + flow_load_;
  now.displacement = displacement_predictor_ + inertia() * a;
  now.velocity = velocity_predictor_ + gamma * h * a;
  now.elastic_force = motion_.elastic(now.displacement);
  now.weighted_elastic_force = (1 + alpha) * now.elastic_force - alpha * elastic_behind_;
  now.stiffness_velocity = motion_.elastic(now.velocity);
  now.stiffness_acceleration = motion_.elastic(a);
  if (motion_.has_viscosity()) {
    Vector force = now.load + inner_force_;
    if (contact_) force += contact_->load();
    now.viscosity_acceleration = motion_.viscous_of(a, force);
    now.viscosity_velocity = viscous_predictor_ + gamma * h * now.viscosity_acceleration;
    if (last_.step == 0 || now.step % renewed == 0) now.viscosity_velocity = motion_.viscous(now.velocity);
    now.viscous_force = (1 + alpha) * now.viscosity_velocity - alpha * viscous_behind_;
  }
  now.inertial_force = a;
  now.acceleration = std::move(a);
  if (flow_) now.flow_load = flow_load_;
  if (contact_) {
    now.contact_force = contact_->load();
    now.interface_force = contact_->interface_force();
    std::tie(now.closed, now.closed_force) = contact_->closed();
  }
  now.flow_stopped = flow_stopped();
  now.ledger = last_.ledger;
  now.first_signs = last_.first_signs;
  return now;
}

}  // namespace plica

#include "plica/dynamics/reduced_step.hpp"

#include <algorithm>
#include <tuple>

#include "plica/core/stopwatch.hpp"

namespace plica {

ReducedStep::ReducedStep(const ModalMotion& motion, const State& last, Vector scene_load, const ReducedFlow* flow,
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
  contact_load_ = contact_acceleration_ = flow_load_;
  if (!flow_) return;
  const Vector extrapolated = last.displacement + weight() * (h * last.velocity + 0.5 * h * h * last.acceleration);
  near_ = !contact_ || !apart(contact_->offsets(extrapolated));
  if (near_)
    widths_ = flow_->widths(extrapolated);
  else
    areas_ = flow_->open_areas(extrapolated);
}

void ReducedStep::move() {
  solve_free();
  take_positions(Vector());
  touch();
}

void ReducedStep::move(const Vector& pressure, Instant) {
  flow_load_ = flow_->load(pressure);
  pressure_ = pressure;
  if (solved_at_.size() == 0) {
    solved_at_ = pressure;
    solve_free();
    take_positions(Vector());
  } else {
    take_positions(pressure - solved_at_);
  }
  touch();
}

void ReducedStep::solve_free() {
  const Stopwatch watch(times_.solve);
  free_ = motion_.solve(scene_load_ + flow_load_ + inner_force_);
  free_end_ = displacement_predictor_ + inertia() * free_;
  if (contact_) free_offsets_ = contact_->offsets(free_end_);
  never_near_ = contact_ != nullptr;
}

void ReducedStep::take_positions(const Vector& change) {
  const Stopwatch watch(times_.load);
  const bool moved = change.size() > 0;
  const double by = inertia();
  if (contact_) {
    Eigen::VectorXf offsets = free_offsets_;
    if (moved) offsets += static_cast<float>(by) * contact_->offset_response(change);
    near_ = !apart(offsets);
    never_near_ = never_near_ && !near_;
    if (near_) {
      if (x_free_.rows() == 0) x_free_ = contact_->positions(free_end_);
      x_ = x_free_;
      if (moved) x_ += by * contact_->pressed(change);
    }
  }
  if (!flow_) return;
  if (near_) {
    if (free_widths_.size() == 0) free_widths_ = flow_->widths(weighted(free_end_));
    widths_ = free_widths_;
    if (moved) widths_ += weight() * by * (flow_->width_response() * change);
  } else {
    if (free_areas_.size() == 0) free_areas_ = flow_->open_areas(weighted(free_end_));
    areas_ = free_areas_;
    if (moved) areas_ += weight() * by * (flow_->area_response() * change);
  }
}

void ReducedStep::touch() {
  if (contact_ == nullptr) return;
  const Stopwatch watch(times_.contact);
  contact_nodal_ = Vector::Zero(3 * contact_->nodes().size());
  contact_load_.setZero();
  contact_acceleration_.setZero();
  if (!near_) {
    contacts_ = {};
    return;
  }
  x_before_ = contact_->ends(last_.displacement);
  const BeforeContact before{x_before_, last_.closed, last_.closed_force, last_.depth, nullptr};
  Points touching;
  contacts_ = contact_->solve(before, x_, std::move(contacts_), touching);
  x_ = std::move(touching);
  if (!contacts_.any_force()) return;
  contacts_.add_forces(contact_nodal_);
  contact_load_ = contact_->forces(contact_nodal_);
  contact_acceleration_ = motion_.solve(contact_load_);
  if (flow_) widths_ += weight() * inertia() * flow_->widths_of(contact_acceleration_);
}

Vector ReducedStep::areas(Instant at) const {
  if (at == Instant::last) return flow_->areas(flow_->widths(last_.displacement));
  return near_ ? flow_->areas(widths_) : areas_;
}

bool ReducedStep::blocks() const {
  const Airflow& airflow = flow_->airflow();
  if (!airflow.stops_at_contact() || !contact_ || !near_) return false;
  const auto in_middle = [&](const Vector3& x) { return airflow.blocks(x[1] + origin_[1], x[2] + origin_[2]); };
  for (std::size_t i = 0; i < contacts_.constraints.size(); ++i)
    if (contacts_.force[static_cast<std::ptrdiff_t>(i)] > 0 && in_middle(x_.row(contacts_.constraints[i].slave)))
      return true;
  const Detector& detector = contact_->collision().detector();
  const auto crossings = detector.edge_crossings(x_, detector.reach(x_before_, x_, last_.depth));
  return std::any_of(crossings.begin(), crossings.end(),
                     [&](const EdgeCrossing& crossing) { return in_middle(crossing.place); });
}

State ReducedStep::end() {
  constexpr int renewed = 64;  // steps after which round-off in the products is taken away
  const Stopwatch watch(times_.solve);
  const auto [alpha, beta, gamma] = motion_.scheme();
  const double h = motion_.step();
  State now;
  now.step = last_.step + 1;
  now.load = scene_load_ + flow_load_;
  Vector a = free_ + contact_acceleration_;
  if (flow_ && pressure_ != solved_at_) a += flow_->response() * (pressure_ - solved_at_);
  now.displacement = displacement_predictor_ + inertia() * a;
  now.velocity = velocity_predictor_ + gamma * h * a;
  now.elastic_force = motion_.elastic(now.displacement);
  now.weighted_elastic_force = (1 + alpha) * now.elastic_force - alpha * elastic_behind_;
  now.stiffness_velocity = motion_.elastic(now.velocity);
  now.stiffness_acceleration = motion_.elastic(a);
  if (motion_.has_viscosity()) {
    now.viscosity_acceleration = motion_.viscous_of(a, now.load + contact_load_ + inner_force_);
    now.viscosity_velocity = viscous_predictor_ + gamma * h * now.viscosity_acceleration;
    if (last_.step == 0 || now.step % renewed == 0) now.viscosity_velocity = motion_.viscous(now.velocity);
    now.viscous_force = (1 + alpha) * now.viscosity_velocity - alpha * viscous_behind_;
  }
  now.inertial_force = a;
  now.acceleration = std::move(a);
  if (flow_) now.flow_load = flow_load_;
  if (contact_) {
    now.contact_force = contact_load_;
    now.interface_force = contact_nodal_;
  }
  std::tie(now.closed, now.closed_force) = contacts_.closed();
  now.flow_stopped = flow_stopped();
  now.ledger = last_.ledger;
  now.first_signs = last_.first_signs;
  return now;
}

}  // namespace plica

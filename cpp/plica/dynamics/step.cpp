#include "plica/dynamics/step.hpp"

#include <algorithm>
#include <tuple>

#include "plica/core/stopwatch.hpp"
#include "plica/dynamics/scene_contact.hpp"
#include "plica/dynamics/scene_flow.hpp"

namespace plica {

Step::Step(const Motion& motion, const State& last, Vector scene_load, SceneContact* contact, StepTimes& times)
    : motion_(motion),
      last_(last),
      contact_(contact),
      times_(times),
      scene_load_(std::move(scene_load)),
      x_previous_(motion.positions(last.displacement)),
      load_(scene_load_),
      free_acceleration_(last.acceleration),
      flow_stopped_(last.flow_stopped) {
  const Stopwatch watch(times_.residual);
  const SchemeCoefficients& c = motion_.scheme();
  const double h = motion_.step(), weight = 1 + c.alpha;
  displacement_predictor_ = last.displacement + h * last.velocity + h * h * (0.5 - c.beta) * last.acceleration;
  velocity_predictor_ = last.velocity + h * (1 - c.gamma) * last.acceleration;
  displacement_behind_ = last.displacement;
  velocity_behind_ = last.velocity;
  if (last.step == 0) {
    displacement_predictor_ += motion_.start().shift;
    displacement_behind_ += motion_.start().displacement;
    velocity_behind_ += motion_.start().velocity;
  }
  inner_force_ = motion_.stiffness() * Vector(c.alpha * displacement_behind_ - weight * displacement_predictor_);
  if (motion_.viscosity())
    inner_force_ += *motion_.viscosity() * Vector(c.alpha * velocity_behind_ - weight * velocity_predictor_);
}

Points Step::extrapolated_positions() const {
  const double h = motion_.step(), weight = 1 + motion_.scheme().alpha;
  const Vector ahead = weight * (h * last_.velocity + 0.5 * h * h * last_.acceleration);
  return x_previous_ + as_points(ahead);
}

Points Step::weighted_positions() const {
  const double alpha = motion_.scheme().alpha;
  return (1 + alpha) * x_ - alpha * x_previous_;
}

void Step::move() {
  load_ = scene_load_;
  move_under_load();
}

void Step::move(const SceneFlow& flow, const Points& loaded, const Vector& pressure) {
  {
    const Stopwatch watch(times_.load);
    load_ = scene_load_;
    flow.add_load(loaded, pressure, load_);
  }
  move_under_load();
}

void Step::move_under_load() {
  const double h = motion_.step();
  solve(load_, free_acceleration_);
  const Vector u = displacement_predictor_ + motion_.scheme().beta * h * h * free_acceleration_;
  x_ = motion_.positions(u);
  if (!contact_) return;
  const Stopwatch watch(times_.contact);
  Points touching;
  contacts_ = contact_->solve(*this, touching);
  x_ = std::move(touching);
}

bool Step::blocks(const SceneFlow& flow) const {
  if (!flow.airflow().stops_at_contact()) return false;
  for (std::size_t i = 0; i < contacts_.constraints.size(); ++i) {
    if (!(contacts_.force[static_cast<std::ptrdiff_t>(i)] > 0)) continue;
    if (flow.blocks(x_.row(contacts_.constraints[i].slave))) return true;
  }
  if (!contact_) return false;
  const Detector& detector = contact_->collision().detector();
  const auto crossings = detector.edge_crossings(x_, detector.reach(x_previous_, x_, last_.depth));
  return std::any_of(crossings.begin(), crossings.end(),
                     [&](const EdgeCrossing& crossing) { return flow.blocks(crossing.place); });
}

void Step::solve(const Vector& force, Vector& a) {
  const Stopwatch watch(times_.solve);
  iterations_ += motion_.solve(force + inner_force_, a);
}

void Step::complete() {
  if (contact_) contact_force_ = Vector::Zero(load_.size());
  acceleration_ = free_acceleration_;
  if (!contacts_.any_force()) return;
  contacts_.add_forces(contact_force_);
  contact_->collision().add_response(contacts_, acceleration_);
  solve(load_ + contact_force_, acceleration_);
}

State Step::end() {
  const double h = motion_.step();
  State now;
  now.step = last_.step + 1;
  now.displacement = displacement_predictor_ + motion_.scheme().beta * h * h * acceleration_;
  now.velocity = velocity_predictor_ + motion_.scheme().gamma * h * acceleration_;
  now.acceleration = std::move(acceleration_);
  now.load = std::move(load_);
  now.contact_force = std::move(contact_force_);
  std::tie(now.closed, now.closed_force) = contacts_.closed();
  now.flow_stopped = flow_stopped_;
  now.ledger = last_.ledger;
  now.first_signs = last_.first_signs;
  return now;
}

}  // namespace plica

#include "plica/dynamics/step.hpp"

#include <algorithm>

#include "plica/core/error.hpp"
#include "plica/dynamics/step_stress.hpp"

namespace plica {

Simulation::Step::Step(Simulation& simulation) {
  const Stopwatch watch(simulation.times_.residual);
  const State& s = simulation.state_;
  const SchemeCoefficients& c = simulation.scheme_;
  const double h = simulation.options_.step, weight = 1 + c.alpha;
  displacement_predictor = s.displacement + h * s.velocity + h * h * (0.5 - c.beta) * s.acceleration;
  velocity_predictor = s.velocity + h * (1 - c.gamma) * s.acceleration;
  displacement_behind = s.displacement;
  velocity_behind = s.velocity;
  if (s.step == 0) {
    displacement_predictor += simulation.start_.shift;
    displacement_behind += simulation.start_.displacement;
    velocity_behind += simulation.start_.velocity;
  }
  inner_force = simulation.stiffness_ * Vector(c.alpha * displacement_behind - weight * displacement_predictor);
  if (simulation.viscosity_)
    inner_force += *simulation.viscosity_ * Vector(c.alpha * velocity_behind - weight * velocity_predictor);
  scene_load = simulation.scene_load(simulation.time() + weight * h);
  x_previous = simulation.positions_from_origin();
  depth_before = s.depth;
  load = scene_load;
  free_acceleration = s.acceleration;
  flow_stopped = s.flow_stopped;
  if (simulation.collision_) simulation.collision_->forget();
}

/// A a = load + contact_force + inner_force, warm-started from a.
void Simulation::solve(Step& step, const Vector& force, Vector& a) {
  const Stopwatch watch(times_.solve);
  Vector rhs = force + step.inner_force;
  scene_.supports.project(rhs);
  const Convergence end = solver_.solve(rhs, a);
  step.iterations += end.iterations;
  if (!end.converged)
    throw SolveFailed("conjugate gradients stopped at residual " + number(end.residual) + " after " +
                      std::to_string(end.iterations) + " iterations (tolerance " +
                      number(solver_.options().tolerance) + "). Try a smaller step, or raise max_iterations.");
}

void Simulation::move(Step& step) {
  const double h = options_.step, weight = 1 + scheme_.alpha;
  solve(step, step.load, step.free_acceleration);
  const Vector u = step.displacement_predictor + scheme_.beta * h * h * step.free_acceleration;
  step.x = reference_ + as_points(u);
  if (!collision_) return;

  const Stopwatch watch(times_.contact);
  const auto* multipliers = std::get_if<Multipliers>(&scene_.contact->enforcement);
  std::optional<StepStress> stress;
  if (node_stress_)
    stress.emplace(*node_stress_, reference_, step.displacement_behind, step.velocity_behind,
                   step.displacement_predictor, step.velocity_predictor, scheme_, h);
  const Collision::Before before{step.x_previous, state_.closed, state_.closed_force, state_.depth,
                                 stress ? &*stress : nullptr};
  Points touching;
  if (!multipliers || std::holds_alternative<EndOfStep>(multipliers->position)) {
    step.contacts = collision_->solve(step.x, scheme_.beta * h * h, before, touching);
    step.x = std::move(touching);
  } else {
    const Points weighted = weight * step.x - scheme_.alpha * step.x_previous;
    step.contacts = collision_->solve(weighted, weight * scheme_.beta * h * h, before, touching);
    step.x = (touching + scheme_.alpha * step.x_previous) / weight;
  }
}

void Simulation::complete(Step& step) {
  if (collision_) step.contact_force = Vector::Zero(step.load.size());
  step.acceleration = step.free_acceleration;
  if (!step.contacts.any_force()) return;
  step.contacts.add_forces(step.contact_force);
  collision_->add_response(step.contacts, step.acceleration);
  solve(step, step.load + step.contact_force, step.acceleration);
}

/// Whether contact lies in the middle of the glottis (Paper A, Sec. 2.4).
bool Simulation::flow_blocked(const Step& step) {
  const auto blocked = [&](const Vector3& x) { return airflow_->blocks(x[1] + origin_[1], x[2] + origin_[2]); };
  for (std::size_t i = 0; i < step.contacts.constraints.size(); ++i) {
    if (!(step.contacts.force[static_cast<std::ptrdiff_t>(i)] > 0)) continue;
    if (blocked(step.x.row(step.contacts.constraints[i].slave))) return true;
  }
  if (!collision_) return false;
  const Detector& detector = collision_->detector();
  const auto crossings = detector.edge_crossings(step.x, detector.reach(step.x_previous, step.x, state_.depth));
  return std::any_of(crossings.begin(), crossings.end(), [&](const EdgeCrossing& c) { return blocked(c.place); });
}

void Simulation::load_by_flow(Step& step, const Points& x, const Vector& pressure) {
  const Stopwatch watch(times_.load);
  step.load = step.scene_load;
  if (origin_.isZero(0))
    airflow_->add_load(x, pressure, step.load);
  else
    airflow_->add_load(in_scene(x), pressure, step.load);
}

void Simulation::couple(Step& step) {
  if (!airflow_) return move(step);
  const Coupling& coupling = scene_.airflow->coupling;
  if (const auto* iterated = std::get_if<Iterated>(&coupling)) return iterate(step, *iterated);
  const Points x = std::holds_alternative<Lagged>(coupling) ? step.x_previous : extrapolated_positions(step);
  step.flow = FlowRecord{airflow_->evaluate(flow_areas(x), step.flow_stopped), 1};
  load_by_flow(step, x, step.flow->state.pressure);
  move(step);
  step.flow_stopped = flow_blocked(step);
}

/// (1 + alpha) (u + h v + h^2 a / 2) - alpha u, at reference positions.
Points Simulation::extrapolated_positions(const Step& step) const {
  const double h = options_.step, weight = 1 + scheme_.alpha;
  const Vector ahead = weight * (h * state_.velocity + 0.5 * h * h * state_.acceleration);
  return step.x_previous + as_points(ahead);
}

void Simulation::iterate(Step& step, const Iterated& coupling) {
  constexpr int depth = 6;  // residual differences kept; sections are few
  Points x = extrapolated_positions(step);
  Vector pressure = airflow_->evaluate(flow_areas(x), step.flow_stopped).pressure;
  Anderson mixing(depth);
  FlowRecord flow;
  std::optional<int> separation;  // once held
  for (flow.sweeps = 1;; ++flow.sweeps) {
    load_by_flow(step, x, pressure);
    move(step);
    const Stopwatch watch(times_.load);
    x = (1 + scheme_.alpha) * step.x - scheme_.alpha * step.x_previous;
    if (!flow.frozen) step.flow_stopped = flow_blocked(step);
    const bool stopped = flow.frozen ? flow.state.stopped : step.flow_stopped;
    flow.state = airflow_->evaluate(flow_areas(x), stopped, separation);
    flow.residual =
        (flow.state.pressure - pressure).cwiseAbs().maxCoeff() / airflow_->options().subglottal_pressure;
    flow.converged = flow.residual <= coupling.tolerance;
    if (flow.converged || flow.sweeps >= coupling.max_sweeps) break;
    if (!flow.frozen && flow.sweeps >= coupling.freeze_after) {
      flow.frozen = true;
      separation = flow.state.separation;
      mixing.forget();
    }
    pressure = mixing.next(pressure, flow.state.pressure);
  }
  step.flow = flow;
}

}  // namespace plica

#include "plica/dynamics/simulation.hpp"

#include <cmath>

#include "plica/core/error.hpp"
#include "plica/core/stopwatch.hpp"
#include "plica/dynamics/step.hpp"

namespace plica {

namespace {

Scene checked(Scene scene) {
  scene.validate();
  scene.mesh = labelled(std::move(scene.mesh));
  return scene;
}

Simulation::Options checked(Simulation::Options options) {
  options.validate();
  return options;
}

}  // namespace

Simulation::Simulation(Scene scene, Options options)
    : scene_(checked(std::move(scene))),
      assembler_(scene_.mesh),
      strain_gauge_(scene_.mesh),
      motion_(scene_, assembler_, checked(options)),
      loads_(scene_, assembler_) {
  if (scene_.airflow) flow_.emplace(scene_, motion_);
  if (scene_.contact) contact_.emplace(scene_, motion_);
  if (contact_)
    seen_ = contact_->nodes();
  else if (flow_)
    seen_ = flow_->airflow().nodes();
  if (flow_) flow_->find_response(scene_.airflow->coupling, motion_, seen_);
  begin();
}

void Simulation::begin() {
  const std::ptrdiff_t unknowns = 3 * scene_.mesh.node_count();
  state_.displacement = scene_.displacement ? Vector(as_vector(*scene_.displacement)) : Vector::Zero(unknowns);
  state_.velocity = scene_.velocity ? Vector(as_vector(*scene_.velocity)) : Vector::Zero(unknowns);
  scene_.supports.project(state_.displacement);
  scene_.supports.project(state_.velocity);
  if (contact_) state_.contact_force = Vector::Zero(unknowns);
  state_.load = loads_.at(0.0);
  const Points x = positions();
  if (const Airflow* flow = airflow()) {  // which knows the scene's coordinates
    const FlowState air = flow->evaluate(flow->areas(x), false);
    state_.flow_load = Vector::Zero(unknowns);
    flow->add_load(x, air.pressure, state_.flow_load);
    state_.load += state_.flow_load;
    state_.supplied_power = air.supplied_power;
    state_.viscous_power = air.viscous_power;
  }
  motion_.begin(state_);
  state_.ledger = opened_ledger(motion_, state_);
  if (contact_) contact_->require_apart(motion_.positions(state_.displacement));
  StepRecord start;
  start.inverted_tissue = static_cast<int>(folded(x));
  state_.first_signs.note(0, start, x, scene_.mesh.cells);
}

StepTimes Simulation::times() const {
  StepTimes times = times_;
  if (contact_) {
    times.detection = contact_->collision().detection_time();
    times.contact -= times.detection;
  }
  return times;
}

Points Simulation::positions() const { return scene_.mesh.points + as_points(state_.displacement); }

Vector Simulation::contact_pressure() const {
  if (contact_ && contact_->pressure().size() > 0) return contact_->pressure();
  return Vector::Zero(scene_.mesh.node_count());
}

void Simulation::set_external_force(Vector force) {
  if (force.size() != step_matrix().rows())
    throw InvalidInput("Simulation", "external force", static_cast<double>(force.size()), "entries",
                       "3 times the " + std::to_string(scene_.mesh.node_count()) + " nodes");
  for (std::ptrdiff_t i = 0; i < force.size(); ++i)
    if (!std::isfinite(force[i]))
      throw InvalidInput("Simulation",
                         std::string("external force along ") + "xyz"[i % 3] + " on node " + std::to_string(i / 3),
                         force[i], "N", "finite");
  loads_.set_external(std::move(force));
}

void Simulation::restore(State state) {
  state.validate(
      {step_matrix().rows(), scene_.mesh.cell_count(), viscosity().has_value(), flow_.has_value(), collision()});
  state_ = std::move(state);
  record_ = StepRecord{};
  record_.time = time();
  if (contact_) contact_->update_pressure(state_, motion_.positions(state_.displacement));
}

void Simulation::advance() {
  const auto failed = [&](const std::exception& failure) {
    const std::int64_t next = state_.step + 1;
    const Vector3& origin = motion_.origin();
    const std::string seen_from = origin.isZero(0) ? ""
                                                   : " (Its places are seen from (" + number(origin[0]) + ", " +
                                                         number(origin[1]) + ", " + number(origin[2]) + ") m.)";
    return SolveFailed("Step " + std::to_string(next) +
                       " (t = " + number(static_cast<double>(next) * motion_.step()) + " s): " + failure.what() +
                       seen_from + state_.first_signs.text(motion_.step(), folded(positions())));
  };
  try {
    const Vector scene_load = loads_.at(time() + (1 + motion_.scheme().alpha) * motion_.step());
    Step step(motion_, state_, scene_load, seen_, contact(), times_);
    if (contact_) {
      const Stopwatch watch(times_.contact);
      contact_->begin(step.x_previous(), state_.depth);
    }
    std::optional<FlowRecord> flow;
    if (flow_)
      flow = couple(scene_.airflow->coupling, *flow_, step);
    else
      step.move();
    step.complete();
    keep(step, flow, scene_load);
  } catch (const SolveFailed& failure) {
    throw failed(failure);
  } catch (const InvalidInput& failure) {  // what was handed in is checked: positions that a step made diverge
    throw failed(failure);
  }
}

void Simulation::keep(Step& step, const std::optional<FlowRecord>& flow, const Vector& scene_load) {
  State now = step.end();
  {
    const Stopwatch watch(times_.ledger);
    if (flow) {
      now.flow_load = now.load - scene_load;
      now.supplied_power = flow->state.supplied_power;
      now.viscous_power = flow->state.viscous_power;
    }
    now.ledger = continued_ledger(motion_, state_, now);
  }
  const Stopwatch watch(times_.record);
  const Points x = motion_.positions(now.displacement);
  StepRecord record;
  record.time = static_cast<double>(now.step) * motion_.step();
  record.iterations = step.iterations();
  record.flow = flow;
  record.strains = strain_gauge_.measure(now.displacement);
  record.inverted_tissue = static_cast<int>(folded_cells(x, scene_.mesh.cells, strain_gauge_.suspects()));
  if (contact_) {
    contact_->update_pressure(now, x);
    record.contact = contact_->record(step, now, x, record.inverted_tissue > 0);
    now.depth = -record.contact->deepest_gap;
  }
  const bool at_origin = motion_.origin().isZero(0);
  now.first_signs.note(now.step, record, at_origin ? x : motion_.in_scene(x), scene_.mesh.cells);
  now.past = std::move(state_.past);
  now.past.add(now.acceleration, step.take_image());
  state_ = std::move(now);
  record_ = record;
}

}  // namespace plica

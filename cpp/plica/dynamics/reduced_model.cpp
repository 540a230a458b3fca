#include "plica/dynamics/reduced_model.hpp"

#include "plica/core/stopwatch.hpp"
#include "plica/dynamics/reduced_step.hpp"

namespace plica {

ReducedModel::ReducedModel(const Scene& scene, const Motion& full, const Airflow* airflow)
    : scene_(scene), full_(full), motion_(full, scene.reduction->basis) {
  if (airflow) flow_.emplace(*airflow, scene.mesh.points, motion_);
  if (scene.contact) contact_.emplace(scene, full, motion_, flow_ ? flow_->response() : Eigen::MatrixXd());
}

State ReducedModel::begun(const State& full) {
  State state;
  state.displacement = motion_.nearest(full.displacement);
  state.velocity = motion_.nearest(full.velocity);
  state.load = motion_.forces(full.load);
  if (flow_) {
    state.flow_load = motion_.forces(full.flow_load);
    state.supplied_power = full.supplied_power;
    state.viscous_power = full.viscous_power;
  }
  if (contact_) {
    state.contact_force = Vector::Zero(motion_.size());
    state.interface_force = Vector::Zero(interface());
  }
  motion_.begin(state);
  state.ledger = opened_ledger(state, state.velocity);
  return state;
}

void ReducedModel::restore(const State& state) {
  if (contact_) contact_->update_pressure(state.contact_at_interface(), contact_->positions(state.displacement));
}

ReducedModel::Taken ReducedModel::step(const State& last, const Vector& scene_load, StepTimes& times) {
  static const std::vector<std::int32_t> none;
  ReducedStep step(motion_, last, scene_load, flow_ ? &*flow_ : nullptr, contact_ ? &*contact_ : nullptr,
                   full_.origin(), times);
  if (contact_) contact_->begin();
  Taken taken;
  if (flow_)
    taken.flow = couple(scene_.airflow->coupling, flow_->airflow(), step);
  else
    step.move();
  State& now = taken.now = step.end();
  {
    const Stopwatch watch(times.ledger);
    if (taken.flow) {
      now.supplied_power = taken.flow->state.supplied_power;
      now.viscous_power = taken.flow->state.viscous_power;
    }
    const LedgerMotion known{motion_.scheme(), motion_.step(), motion_.has_viscosity(), motion_.start().shift,
                             none};
    now.ledger = continued_ledger(known, last, now, now.velocity);
  }
  const Stopwatch watch(times.record);
  if (contact_) {
    taken.contact.emplace();
    if (step.apart()) {
      contact_->forget_pressure();
    } else {
      const Points before = contact_->ends(last.displacement), &x = contact_->ends(now.displacement);
      const Contact contact = now.contact_at_interface();
      contact_->update_pressure(contact, x);
      taken.contact = contact_->record(step.contacts(), before, last.depth, contact, x);
    }
    now.depth = -taken.contact->deepest_gap;
  }
  return taken;
}

}  // namespace plica

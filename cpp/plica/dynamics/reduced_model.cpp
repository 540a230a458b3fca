#include "plica/dynamics/reduced_model.hpp"

#include <algorithm>

#include "plica/core/stopwatch.hpp"
#include "plica/dynamics/mirror_contact.hpp"
#include "plica/dynamics/reduced_collision.hpp"

namespace plica {

namespace {

/// The part's rows of a basis, where the motion is of a part. Throws InvalidInput for a vector that is not
/// symmetric.
Eigen::MatrixXd basis_of(const Scene& scene, const Motion& full) {
  const Eigen::MatrixXd& whole = scene.reduction->basis;
  if (!full.images()) return whole;
  Eigen::MatrixXd part(full.stiffness().rows(), whole.cols());
  for (std::ptrdiff_t j = 0; j < whole.cols(); ++j)
    part.col(j) = full.images()->part_of(whole.col(j), "vector " + std::to_string(j) + " of the reduction's basis",
                                         scene.mesh.points);
  return part;
}

/// The nodes whose mediolateral positions a step needs: those of the airflow, and of a symmetric scene the nodes
/// of the contact's surfaces, that can cross the plane between these.
Mediolateral positions_seen(const Scene& scene, const Motion& full, const ModalMotion& motion,
                            const Airflow* airflow) {
  const MirrorImages* images = full.images();
  std::vector<std::int32_t> contact, others;
  if (images && scene.contact)
    for (const Triangles* side : {&scene.contact->airway.first, &scene.contact->airway.second})
      for (const std::int32_t node : side->reshaped<Eigen::RowMajor>())
        if (const std::int32_t own = images->node_of(node);
            !full.supports().fixed(3 * static_cast<std::ptrdiff_t>(own)))
          contact.push_back(own);
  if (airflow)
    for (const std::int32_t node : airflow->nodes()) others.push_back(images ? images->node_of(node) : node);
  std::sort(contact.begin(), contact.end());
  std::sort(others.begin(), others.end());
  return {full, motion, contact, others};
}

}  // namespace

std::unique_ptr<ReducedContact> reduced_contact(const Scene& scene, const Motion& full, const ModalMotion& motion,
                                                const Mediolateral& positions) {
  if (full.images()) return std::make_unique<MirrorContact>(scene, full, motion, positions);
  return std::make_unique<ReducedCollision>(scene, full, motion, positions);
}

ReducedModel::ReducedModel(const Scene& scene, const Motion& full, AirColumn* air)
    : scene_(scene),
      full_(full),
      motion_(full, basis_of(scene, full), scene.reduction->damping_ratio, scene.reduction->last.get()),
      positions_(positions_seen(scene, full, motion_, air ? &air->airflow() : nullptr)),
      air_(air) {
  if (air) flow_.emplace(air->airflow(), full, motion_, positions_, air->has_tubes());
  if (scene.contact) contact_ = reduced_contact(scene, full, motion_, positions_);
  step_.emplace(motion_, positions_, flow_ ? &*flow_ : nullptr, contact_.get(), full.origin());
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
    state.air = full.air;
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
  if (contact_) contact_->restore(state);
}

ReducedModel::Taken ReducedModel::step(const State& last, const Vector& scene_load, StepTimes& times, State& now) {
  static const std::vector<std::int32_t> none;
  Taken taken;
  AirwayPressure ends;
  if (air_) {
    const double h = motion_.step();
    const AirColumn::Instant load = load_instant(scene_.airflow->coupling);
    air_->begin_step(last.air, static_cast<double>(last.step) * h, (1 + motion_.scheme().alpha) * h, load);
    const Air& air = air_->air(load);
    ends = {air.subglottal_pressure, {}, air.supraglottal_pressure};
  }
  step_->begin(last, scene_load, ends, times);
  if (air_)
    couple(scene_.airflow->coupling, *air_, *step_, taken.flow);
  else
    step_->move();
  step_->end(now);
  if (air_) now.air = air_->end_step(taken.flow->state);
  {
    const Stopwatch watch(times.ledger);
    if (taken.flow) {
      now.supplied_power = taken.flow->state.supplied_power;
      now.viscous_power = taken.flow->state.viscous_power;
      now.inertial_power = taken.flow->state.inertial_power;
    }
    const LedgerMotion known{motion_.scheme(), motion_.step(), motion_.has_viscosity(), motion_.start().shift,
                             none};
    now.ledger = continued_ledger(known, last, now, now.velocity);
  }
  const Stopwatch watch(times.record);
  if (contact_) {
    taken.contact = contact_->record(now);
    now.depth = -taken.contact->deepest_gap;
  }
  return taken;
}

}  // namespace plica

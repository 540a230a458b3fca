#include "plica/dynamics/coupling.hpp"

#include <cmath>
#include <optional>

#include "plica/core/error.hpp"
#include "plica/core/stopwatch.hpp"
#include "plica/dynamics/anderson.hpp"
#include "plica/dynamics/record.hpp"

namespace plica {

namespace {

using Instant = CoupledStep::Instant;

/// The flow through the airway of the step as it is.
FlowState flow_through(const CoupledStep& step, const AirColumn& air, Instant at,
                       const std::optional<AirColumn::Held>& held = {}) {
  if (!air.has_tubes() && !air.has_inertance()) return air.evaluate(step.areas(at), at, held);
  const AirwayExpansion moving = step.expansion(at);
  return air.evaluate(step.areas(at), at, held, &moving);
}

/// Under the load of the flow through the sections as they are then; the residual is by how much that through the
/// sections where they have come to differs from it.
void once(Instant at, AirColumn& air, CoupledStep& step, std::optional<FlowRecord>& flow) {
  if (flow) {
    step.move_again();
  } else {
    {
      const Stopwatch watch(step.times().load);
      FlowRecord first;
      first.state = flow_through(step, air, at);
      first.sweeps = 1;
      flow = std::move(first);
    }
    step.move(flow->state.on_walls(), at);
  }
  const Stopwatch watch(step.times().load);
  air.stop(step.blocks());
  const FlowState reached = flow_through(step, air, Instant::weighted);
  flow->residual = pressure_difference(air.airflow(), reached.pressure, flow->state.pressure);
}

/// `before`: what the flow did in the rounds before, none in the first.
FlowRecord iterate(const Iterated& coupling, AirColumn& air, CoupledStep& step,
                   const std::optional<FlowRecord>& before) {
  constexpr int depth = 6;         // residual differences kept; sections are few
  constexpr int many_rounds = 10;  // of freeze_after sweeps: where the flow jumps from round to round
  AirwayPressure pressure = flow_through(step, air, Instant::weighted).on_walls();
  Anderson mixing(depth);
  for (const Secant& known : air.remembered().secants) mixing.take(known);
  Vector first, image_of_first;
  FlowRecord record;
  std::optional<AirColumn::Held> held;
  const auto hold = [&](const FlowState& state) {
    record.frozen = true;
    held = {state.stopped, state.separation};
  };
  const bool jumps = air.airflow().stops_at_contact();
  if (before && jumps && (before->frozen || before->sweeps >= many_rounds * coupling.freeze_after))
    hold(before->state);
  for (record.sweeps = 1;; ++record.sweeps) {
    step.move(pressure, Instant::weighted);
    const Stopwatch watch(step.times().load);
    if (!held) air.stop(step.blocks());
    record.state = flow_through(step, air, Instant::weighted, held);
    const Vector found = air.has_tubes() ? record.state.on_walls().all() : record.state.pressure;
    const Vector taken = air.has_tubes() ? pressure.all() : pressure.sections;
    record.residual = pressure_difference(air.airflow(), found, taken);
    if (record.sweeps == 1 && air.has_tubes()) {
      first = taken;
      image_of_first = found;
    } else if (record.sweeps == 2 && air.has_tubes()) {
      const Vector image = found - image_of_first;
      air.remember({image, image - (taken - first)});
    }
    record.converged = record.residual <= coupling.tolerance;
    if (record.converged || record.sweeps >= coupling.max_sweeps) return record;
    if (!held && record.sweeps >= coupling.freeze_after && jumps) {
      hold(record.state);
      mixing.forget();
    }
    const Vector next = mixing.next(taken, found);
    if (air.has_tubes())
      pressure = AirwayPressure::of(next);
    else  // at the ends it is the air's, whatever flows
      pressure.sections = next;
  }
}

}  // namespace

Instant load_instant(const Coupling& coupling) {
  return std::holds_alternative<Lagged>(coupling) ? Instant::last : Instant::weighted;
}

double pressure_difference(const Airflow& flow, const Vector& one, const Vector& other) {
  return (one - other).cwiseAbs().maxCoeff() / flow.options().subglottal_pressure;
}

void Iterated::validate() const {
  if (!(tolerance > 0) || !std::isfinite(tolerance))
    throw InvalidInput("Iterated", "tolerance", tolerance, "subglottal pressures", "> 0 and finite");
  if (max_sweeps < 1) throw InvalidInput("Iterated", "max_sweeps", max_sweeps, "", ">= 1");
  if (freeze_after < 1) throw InvalidInput("Iterated", "freeze_after", freeze_after, "", ">= 1");
}

void couple(const Coupling& coupling, AirColumn& air, CoupledStep& step, std::optional<FlowRecord>& flow) {
  const auto* iterated = std::get_if<Iterated>(&coupling);
  if (!iterated) return once(load_instant(coupling), air, step, flow);
  const int sweeps = flow ? flow->sweeps : 0;
  flow = iterate(*iterated, air, step, flow);
  flow->sweeps += sweeps;
}

}  // namespace plica

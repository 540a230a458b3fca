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

/// Under the load of the flow through the sections as they are then; the residual is by how much that through the
/// sections where they have come to differs from it.
FlowRecord once(Instant at, const Airflow& flow, CoupledStep& step) {
  FlowRecord record{flow.evaluate(step.areas(at), step.air(at), step.flow_stopped()), 1};
  step.move(record.state.pressure, at);
  const Air air = step.air(Instant::weighted);
  const Vector reached = flow.evaluate(step.areas(Instant::weighted), air, step.flow_stopped()).pressure;
  record.residual = pressure_difference(flow, reached, record.state.pressure);
  step.set_flow_stopped(step.blocks());
  return record;
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

FlowRecord couple(const Lagged&, const Airflow& flow, CoupledStep& step) {
  return once(Instant::last, flow, step);
}

FlowRecord couple(const Extrapolated&, const Airflow& flow, CoupledStep& step) {
  return once(Instant::weighted, flow, step);
}

FlowRecord couple(const Iterated& coupling, const Airflow& flow, CoupledStep& step) {
  constexpr int depth = 6;  // residual differences kept; sections are few
  const Air air = step.air(Instant::weighted);
  Vector pressure = flow.evaluate(step.areas(Instant::weighted), air, step.flow_stopped()).pressure;
  Anderson mixing(depth);
  FlowRecord record;
  std::optional<int> separation;  // once held
  for (record.sweeps = 1;; ++record.sweeps) {
    step.move(pressure, Instant::weighted);
    const Stopwatch watch(step.times().load);
    if (!record.frozen) step.set_flow_stopped(step.blocks());
    const bool stopped = record.frozen ? record.state.stopped : step.flow_stopped();
    record.state = flow.evaluate(step.areas(Instant::weighted), air, stopped, separation);
    record.residual = pressure_difference(flow, record.state.pressure, pressure);
    record.converged = record.residual <= coupling.tolerance;
    if (record.converged || record.sweeps >= coupling.max_sweeps) return record;
    if (!record.frozen && record.sweeps >= coupling.freeze_after && flow.stops_at_contact()) {
      record.frozen = true;
      separation = record.state.separation;
      mixing.forget();
    }
    pressure = mixing.next(pressure, record.state.pressure);
  }
}

FlowRecord couple(const Coupling& coupling, const Airflow& flow, CoupledStep& step) {
  return std::visit([&](const auto& chosen) { return couple(chosen, flow, step); }, coupling);
}

}  // namespace plica

#include "plica/dynamics/coupling.hpp"

#include <cmath>
#include <optional>

#include "plica/core/error.hpp"
#include "plica/core/stopwatch.hpp"
#include "plica/dynamics/anderson.hpp"
#include "plica/dynamics/scene_flow.hpp"
#include "plica/dynamics/step.hpp"

namespace plica {

namespace {

/// Under the load of the flow through the sections at x (n, 3).
FlowRecord once(const Points& x, const SceneFlow& flow, Step& step) {
  const FlowRecord record{flow.airflow().evaluate(flow.areas(x), step.flow_stopped()), 1};
  step.move(flow, x, record.state.pressure);
  step.set_flow_stopped(step.blocks(flow));
  return record;
}

}  // namespace

void Iterated::validate() const {
  if (!(tolerance > 0) || !std::isfinite(tolerance))
    throw InvalidInput("Iterated", "tolerance", tolerance, "subglottal pressures", "> 0 and finite");
  if (max_sweeps < 1) throw InvalidInput("Iterated", "max_sweeps", max_sweeps, "", ">= 1");
  if (freeze_after < 1) throw InvalidInput("Iterated", "freeze_after", freeze_after, "", ">= 1");
}

FlowRecord couple(const Lagged&, const SceneFlow& flow, Step& step) { return once(step.x_previous(), flow, step); }

FlowRecord couple(const Extrapolated&, const SceneFlow& flow, Step& step) {
  return once(step.weighted_positions(), flow, step);
}

FlowRecord couple(const Iterated& coupling, const SceneFlow& flow, Step& step) {
  constexpr int depth = 6;  // residual differences kept; sections are few
  const Airflow& airflow = flow.airflow();
  const Points& x = step.weighted_positions();
  Vector pressure = airflow.evaluate(flow.areas(x), step.flow_stopped()).pressure;
  Anderson mixing(depth);
  FlowRecord record;
  std::optional<int> separation;  // once held
  for (record.sweeps = 1;; ++record.sweeps) {
    step.move(flow, x, pressure);
    const Stopwatch watch(step.times().load);
    if (!record.frozen) step.set_flow_stopped(step.blocks(flow));
    const bool stopped = record.frozen ? record.state.stopped : step.flow_stopped();
    record.state = airflow.evaluate(flow.areas(x), stopped, separation);
    record.residual =
        (record.state.pressure - pressure).cwiseAbs().maxCoeff() / airflow.options().subglottal_pressure;
    record.converged = record.residual <= coupling.tolerance;
    if (record.converged || record.sweeps >= coupling.max_sweeps) return record;
    if (!record.frozen && record.sweeps >= coupling.freeze_after && airflow.stops_at_contact()) {
      record.frozen = true;
      separation = record.state.separation;
      mixing.forget();
    }
    pressure = mixing.next(pressure, record.state.pressure);
  }
}

FlowRecord couple(const Coupling& coupling, const SceneFlow& flow, Step& step) {
  return std::visit([&](const auto& chosen) { return couple(chosen, flow, step); }, coupling);
}

}  // namespace plica

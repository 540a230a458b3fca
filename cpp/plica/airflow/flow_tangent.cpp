#include "plica/airflow/flow_tangent.hpp"

#include <algorithm>
#include <cmath>

#include "plica/core/error.hpp"

namespace plica {

namespace {

constexpr double relative_step = 1e-6;

/// Pressures above the supraglottal one, the flow, and momenta where there is inertance.
Vector answers(const FlowState& state) {
  Vector all(state.pressure.size() + 1 + state.momentum.size());
  all << (state.pressure.array() - state.supraglottal_pressure).matrix(), state.flow, state.momentum;
  return all;
}

}  // namespace

FlowTangent flow_tangent(const Airflow& airflow, const Vector& areas, const Air& air) {
  const double drop = air.subglottal_pressure - air.supraglottal_pressure;
  if (!(drop > 0)) throw InvalidInput("flow_tangent", "drop of pressure", drop, "Pa", "> 0");
  if (air.impedance() != 0)
    throw InvalidInput("flow_tangent", "impedance of the air", air.impedance(), "Pa s/m^3",
                       "0: the pressures at the ends are given");
  FlowTangent found;
  found.state = airflow.evaluate(areas, air);
  std::optional<int> separation;
  if (airflow.stops_at_contact()) separation = found.state.separation;
  const auto answer = [&](const Vector& a, const Air& driven) {
    return answers(airflow.evaluate(a, driven, found.state.stopped, separation));
  };
  const Vector here = answers(found.state);
  const std::ptrdiff_t count = areas.size(), momenta = found.state.momentum.size();
  const double least = areas.cwiseAbs().maxCoeff() * 1e-6;
  found.pressure_by_area.resize(count, count);
  found.flow_by_area.resize(count);
  found.momentum_by_area.resize(momenta, momenta);
  Vector moved = areas;
  for (std::ptrdiff_t j = 0; j < count; ++j) {
    const double step = relative_step * std::max(std::abs(areas[j]), least);
    moved[j] = areas[j] + step;
    const Vector more = answer(moved, air);
    moved[j] = areas[j] - step;
    const Vector less = answer(moved, air);
    moved[j] = areas[j];
    found.pressure_by_area.col(j) = (more - less).head(count) / (2 * step);
    found.flow_by_area[j] = (more[count] - less[count]) / (2 * step);
    if (momenta > 0) found.momentum_by_area.col(j) = (more - less).tail(momenta) / (2 * step);
    const double bend = (more - 2 * here + less).head(count).cwiseAbs().maxCoeff();
    found.kink = std::max(found.kink, bend / (relative_step * drop));
  }
  Air driven = air;
  const double step = 1e-6 * drop;
  driven.subglottal_pressure = air.subglottal_pressure + step;
  const Vector more = answer(areas, driven);
  driven.subglottal_pressure = air.subglottal_pressure - step;
  const Vector less = answer(areas, driven);
  found.pressure_by_drop = (more - less).head(count) / (2 * step);
  found.flow_by_drop = (more[count] - less[count]) / (2 * step);
  found.momentum_by_drop = (more - less).tail(momenta) / (2 * step);
  found.from_below = here.head(count) / drop;
  found.pressure_by_expansion.resize(momenta, momenta);
  for (std::ptrdiff_t j = 0; j < momenta; ++j) {  // linear
    const AirwayExpansion moving{0.0, found.state.flow * Vector::Unit(count, j), 0.0};
    const FlowState filled = airflow.evaluate(areas, air, false, std::nullopt, &moving);
    found.pressure_by_expansion.col(j) = (filled.pressure - found.state.pressure) / found.state.flow;
    found.from_below[j] = (filled.flow_below - filled.flow) / found.state.flow;
  }
  return found;
}

}  // namespace plica

#pragma once
#include <optional>
#include <variant>

#include "plica/airflow/air_column.hpp"

namespace plica {

struct FlowRecord;
struct StepTimes;

/// What a coupling sees of a step in the making: the areas of its airway, which it moves by section pressures.
class CoupledStep {
 public:
  using Instant = AirColumn::Instant;
  virtual ~CoupledStep() = default;
  /// (s) m^2; weighted ones are extrapolated until it is moved, then those of where it has been moved.
  virtual Vector areas(Instant at) const = 0;
  /// How fast the walls of the airway give way then, extrapolated as areas are.
  virtual AirwayExpansion expansion(Instant at) const = 0;
  /// Moves it under this pressure, which acts on the tissue where it is `at`.
  virtual void move(const AirwayPressure& pressure, Instant at) = 0;
  /// Moves it under the load that it has, as another force of its tissue asks for; that of linear tissue never
  /// does.
  virtual void move_again() {}
  /// Whether contact, nodes or edges, lies in the middle of the glottis.
  virtual bool blocks() const = 0;
  virtual StepTimes& times() const = 0;
};

/// The load of the last known positions, x_n, as in the thesis: it lags and feeds energy in.
struct Lagged {};
/// The load of positions extrapolated to t_{n+1+alpha}: second order, one evaluation a step.
struct Extrapolated {};
/// The load of the step's own positions at t_{n+1+alpha}: fixed point, accelerated by Anderson mixing. Bernoulli's
/// flow jumps where the section of least area changes or the flow stops, and a fixed point may then not exist:
/// from sweep `freeze_after` on the section of separation and the stop are held for the rest of the step, and the
/// step is counted; so they are from ten times as many on in all rounds of a step. One that still has none after
/// `max_sweeps` keeps its last load, of positions that differ by the recorded residual: equilibrium holds, the
/// coupling is that of a lagged load for this step, and it is counted too.
struct Iterated {
  double tolerance = 1e-5;  // -, > 0: largest change of a section's pressure, in subglottal ones after their rise
  int max_sweeps = 40;      // >= 1; with Bernoulli's flow > freeze_after
  int freeze_after = 8;     // >= 1; of Bernoulli's flow, no other jumps
  void validate() const;    // throws InvalidInput
};
using Coupling = std::variant<Lagged, Extrapolated, Iterated>;

/// When the load of a step is evaluated, and with it the pressure that drives the flow.
CoupledStep::Instant load_instant(const Coupling& coupling);

/// Largest difference of section pressures (s) Pa, in subglottal ones after their rise.
double pressure_difference(const Airflow& flow, const Vector& one, const Vector& other);

/// Moves the step, which has begun for the air too, under the pressure of the flow through it, and says what the
/// flow did. `flow` is what it did in the step's rounds before, each with another force of the tissue, and none in
/// the first: a coupling that does not iterate keeps the load of that one, another counts its sweeps on.
void couple(const Coupling& coupling, AirColumn& air, CoupledStep& step, std::optional<FlowRecord>& flow);

}  // namespace plica

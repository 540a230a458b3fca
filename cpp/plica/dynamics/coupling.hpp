#pragma once
#include <variant>

namespace plica {

class SceneFlow;
class Step;
struct FlowRecord;

/// The load of the last known positions, x_n, as in the thesis: it lags and feeds energy in.
struct Lagged {};
/// The load of positions extrapolated to t_{n+1+alpha}: second order, one evaluation a step.
struct Extrapolated {};
/// The load of the step's own positions at t_{n+1+alpha}: fixed point, accelerated by Anderson mixing. Bernoulli's
/// flow jumps where the section of least area changes or the flow stops, and a fixed point may then not exist:
/// from sweep `freeze_after` on the section of separation and the stop are held for the rest of the step, and the
/// step is counted. One that still has none after `max_sweeps` keeps its last load, of positions that differ by
/// the recorded residual: equilibrium holds, the coupling is that of a lagged load for this step, and it is
/// counted too.
struct Iterated {
  double tolerance = 1e-5;  // -, > 0: largest change of a section's pressure, in subglottal pressures
  int max_sweeps = 40;      // >= 1; with Bernoulli's flow > freeze_after
  int freeze_after = 8;     // >= 1; of Bernoulli's flow, no other jumps
  void validate() const;    // throws InvalidInput
};
using Coupling = std::variant<Lagged, Extrapolated, Iterated>;

/// Moves the step (Step::move) under the pressure of the flow through it, and says what the flow did.
FlowRecord couple(const Lagged& coupling, const SceneFlow& flow, Step& step);
FlowRecord couple(const Extrapolated& coupling, const SceneFlow& flow, Step& step);
FlowRecord couple(const Iterated& coupling, const SceneFlow& flow, Step& step);
FlowRecord couple(const Coupling& coupling, const SceneFlow& flow, Step& step);

}  // namespace plica

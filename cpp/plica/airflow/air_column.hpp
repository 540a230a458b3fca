#pragma once
#include <optional>
#include <vector>

#include "plica/airflow/airflow.hpp"

namespace plica {

/// The air below and above the glottis: what drives the flow in a step, and what it remembers from step to step.
/// This one has no length. The subglottal pressure acts below the sections and none above them; what it remembers
/// is whether contact stopped the flow, which matters to Bernoulli's alone.
class AirColumn {
 public:
  enum class Instant { last, weighted };  // t_n, t_{n+1+alpha}
  /// At the end of a step, as what a file keeps.
  struct Memory {
    bool flow_stopped = false;
    std::vector<double> numbers() const;
    /// Throws InvalidInput for numbers that are not such.
    static Memory of(const std::vector<double>& numbers);
  };
  /// What an evaluation keeps, whatever the areas.
  struct Held {
    bool stopped;
    int separation;
  };

  /// The airflow must outlive it.
  explicit AirColumn(const Airflow& airflow) : airflow_(&airflow) {}

  const Airflow& airflow() const { return *airflow_; }
  /// The flow through areas (s) m^2 at t = 0, before which nothing was.
  FlowState start(const Vector& areas);
  /// A step begins at t_n = `last` (s), whose loads are those of t_n + `ahead`.
  void begin_step(const Memory& memory, double last, double ahead);
  /// What drives the flow then.
  const Air& air(Instant at) const { return at == Instant::last ? air_last_ : air_weighted_; }
  /// The flow through areas (s) m^2 then, and how it presses.
  FlowState evaluate(const Vector& areas, Instant at, const std::optional<Held>& held = {}) const;
  /// Whether contact stops the flow, from now on.
  void stop(bool stopped) { now_.flow_stopped = stopped; }
  bool stopped() const { return now_.flow_stopped; }
  /// What it remembers of the step that has been made.
  Memory end_step() const { return now_; }

 private:
  const Airflow* airflow_;
  Air air_last_, air_weighted_;
  Memory now_;
};

}  // namespace plica

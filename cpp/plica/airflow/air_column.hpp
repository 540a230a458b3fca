#pragma once
#include <optional>
#include <vector>

#include "plica/airflow/airflow.hpp"
#include "plica/airflow/secant.hpp"
#include "plica/airflow/transmission_line.hpp"

namespace plica {

/// The air of tubes beside a flow: of its density and viscosity, or that of air where its model has none.
Gas gas_of(const Airflow::Options& flow, double sound_speed);

/// The air below and above the glottis: what drives the flow in a step, and what it remembers from step to step:
/// whether contact stopped the flow, which matters to Bernoulli's alone, and, at the instant of the last step's
/// load, the sound in its tubes and, with inertance, the momentum of the air in the glottis. Rates of that are
/// backward differences of second order over the last two steps, of first order in the first one.
class AirColumn {
 public:
  enum class Instant { last, weighted };  // t_n, t_{n+1+alpha}
  /// At the end of a step, as what a file keeps.
  struct Memory {
    bool flow_stopped = false;
    double source = 0.0;                        // Pa or m^3/s, behind the trachea
    double flow_below = 0.0, flow_above = 0.0;  // m^3/s
    LineWork trachea_work, tract_work;          // since t = 0
    Vector trachea, tract;                      // TransmissionLine states; empty without
    // (s) Pa s, FlowState::momentum of the last load and of that before, and the time (s) between them, 0 where
    // the flow had always been so; empty without inertance.
    Vector momentum, momentum_before;
    double interval = 0.0;
    // How the pressures at sections and ends (s + 2) Pa answered to theirs in the last two couplings that iterated
    // between tubes; newest last.
    std::vector<Secant> secants;
    std::vector<double> numbers() const;
    /// Throws InvalidInput for numbers that are not such.
    static Memory of(const std::vector<double>& numbers);
  };
  /// What an evaluation keeps, whatever the areas.
  struct Held {
    bool stopped;
    int separation;
  };

  /// The airflow must outlive it. step: s, that between loads after the first. Throws InvalidInput.
  AirColumn(const Airflow& airflow, double step, const Tubes& tubes = {});
  AirColumn(const AirColumn&) = delete;  // its steps know its lines
  AirColumn& operator=(const AirColumn&) = delete;

  const Airflow& airflow() const { return *airflow_; }
  /// Whether flows change the pressures at the ends.
  bool has_tubes() const { return trachea_ || tract_; }
  /// The flow through areas (s) m^2 at t = 0, before which it has always been so.
  FlowState start(const Vector& areas);
  /// A step begins at t_n = `last` (s), whose loads are those of t_n + `ahead`, or of t_n where that is their
  /// instant.
  void begin_step(const Memory& memory, double last, double ahead, Instant load = Instant::weighted);
  /// What drives the flow then.
  const Air& air(Instant at) const { return at == Instant::last ? air_last_ : air_weighted_; }
  /// The flow through areas (s) m^2 then, and how it presses on walls that move so; at rest without `moving`.
  FlowState evaluate(const Vector& areas, Instant at, const std::optional<Held>& held = {},
                     const AirwayExpansion* moving = nullptr) const;
  /// Whether contact stops the flow, from now on.
  void stop(bool stopped) { now_.flow_stopped = stopped; }
  bool stopped() const { return now_.flow_stopped; }
  /// What the coupling of the step has learned; the latest two are kept.
  void remember(Secant secant);
  const Memory& remembered() const { return now_; }
  /// What it remembers of the step that has been made, whose load was of this flow.
  Memory end_step(const FlowState& flow);
  /// Throws InvalidInput for a memory that is not of these tubes.
  void require(const Memory& memory) const;
  /// Whether the air between first and last section has to be accelerated.
  bool has_inertance() const { return inertial_; }
  /// m^3/s, out of the tract's far end, with this memory; without a tract the flow out of the glottis.
  double lip_flow(const Memory& memory) const;
  /// What drives the trachea's far end, in shares of the flow's subglottal pressure, or of the supplied flow.
  double supply_rise(const Memory& memory) const;
  /// J, of sound and walls in both tubes.
  double tube_energy(const Memory& memory) const;

 private:
  /// A tube, and its steps: the one after t = 0 may be shorter.
  struct Side {
    Side(const Tube& tube, const Gas& gas, const char* where, double step);
    TransmissionLine line;
    LineStep regular;
    std::optional<LineStep> first;
    LineStep& begin(double duration, double regular_duration);
    LineStep* taken = nullptr;
  };

  /// What drives the trachea's far end, of the air then.
  double source(const Air& air) const;
  void begin_tubes(const Memory& memory, Air& air);
  void begin_inertia(const Memory& memory);

  const Airflow* airflow_;
  double step_;
  std::optional<Side> trachea_, tract_;
  std::optional<double> supplied_flow_;  // m^3/s, from the end of its rise on; absent: a pressure
  double source_then_ = 0.0;
  bool inertial_;
  AirInertia inertia_;     // of a step
  double duration_ = 0.0;  // s, of a step, between loads
  Air air_last_, air_weighted_;
  Memory now_;
};

}  // namespace plica

#pragma once
#include <complex>

#include "plica/airflow/tube.hpp"
#include "plica/core/types.hpp"

namespace plica {

/// Plane waves in a tube, pressures at nodes and flows of the elements between them (docs/theory/tubes.md):
///   C dp/dt = U_before - U_after - U_wall,   L dU/dt = p_before - p_after - R U,
///   m/S dU_wall/dt + b/S U_wall + k/S V_wall = p,   dV_wall/dt = U_wall,
/// flows positive away from the glottis. Its state is a vector of size(): the pressures, that at the glottis
/// first; flows; of yielding walls flows and volumes; of a radiating end the flow of its inertance.
class TransmissionLine {
 public:
  static constexpr double longest_element = 4e-3;  // m
  /// Elements are at most `longest` m long. Throws InvalidInput; `where` is the tube's name in its text.
  TransmissionLine(const Tube& tube, const Gas& gas, const char* where, double longest = longest_element);

  std::ptrdiff_t size() const {
    return nodes() + elements() + (walls_ ? 2 * nodes() : 0) + (end_ == End::radiating);
  }
  /// The state of a steady flow (m^3/s) under this source (Pa or m^3/s; none of a radiating end).
  Vector steady(double flow, double source) const;
  /// Pa s/m^3, between the glottis and what is held at the far end; that of a supplied flow has none, and is 0.
  double steady_resistance() const;
  /// J, of sound and walls.
  double energy(const Vector& state) const;
  /// m^3/s, at the far end, outwards.
  double end_flow(const Vector& state, double source) const;
  /// What a flow exp(s t) at the glottis leads to, nothing driving the far end.
  struct Response {
    std::complex<double> impedance;  // Pa s/m^3, pressure at the glottis over flow there
    std::complex<double> transfer;   // flow at the far end, outwards, over flow at the glottis
  };
  /// s: 1/s, i 2 pi f at a frequency f, not 0. Poles of both are its resonances. Throws InvalidInput.
  Response response(std::complex<double> s) const;

 private:
  friend class LineStep;
  friend struct LineSystem line_system(const TransmissionLine& line);
  std::ptrdiff_t nodes() const { return compliance_.size(); }
  std::ptrdiff_t elements() const { return inertance_.size(); }

  Vector compliance_;            // (n) m^3/Pa
  Vector inertance_, friction_;  // (n - 1) Pa s^2/m^3, Pa s/m^3
  std::optional<YieldingWall> walls_;
  Vector wall_area_;  // (n) m^2
  enum class End { radiating, held, resistive, supplied } end_;
  double end_resistance_ = 0.0, end_inertance_ = 0.0;  // Pa s/m^3, Pa s^2/m^3
};

/// Energy that crosses the borders of a line or is lost in it, J.
struct LineWork {
  double port = 0.0;      // in at the glottis
  double source = 0.0;    // in at the far end
  double radiated = 0.0;  // out at a radiating end
  double lost = 0.0;      // to friction, walls and a supply's resistance: what is neither stored nor radiated
};

/// Takes a line from an instant to one that is `duration` later, in substeps of the implicit midpoint rule through
/// which flow at the glottis and source are linear in time. The pressure there at the end is then affine in the
/// flow there at the end.
class LineStep {
 public:
  static constexpr double longest_substep = 6.25e-6;  // s
  /// The line must outlive it. duration: s, >= 0; substeps are at most `longest` s.
  LineStep(const TransmissionLine& line, double duration, double longest = longest_substep);

  /// A step begins from this state, flow at the glottis (m^3/s) and source, which becomes `source_then`.
  void begin(const Vector& state, double flow, double source, double source_then);
  /// Pa at the glottis at the step's end: pressure() + impedance() * flow there then.
  double pressure() const { return pressure_; }
  double impedance() const { return impedance_; }  // Pa s/m^3
  /// The state that this flow at the glottis leads to; adds what it did to `work`, if that is asked for.
  Vector end(double flow, LineWork* work = nullptr) const;

 private:
  struct Path {
    double flow, flow_then, source, source_then;
  };
  /// Of the middle of each substep, Pa and m^3/s; `inward` is the flow into the line at a far end that does not
  /// radiate.
  struct Borders {
    Vector near, far, inward;
  };
  void run(Vector& state, const Path& path, Borders& borders) const;
  /// Under the flow and the source of its middle.
  void substep(Vector& state, double flow, double source, Borders& borders, int at) const;
  double source_at(int substep) const;
  void add_work(double flow, const Vector& state, LineWork& work) const;

  const TransmissionLine& line_;
  int count_;       // substeps
  double substep_;  // s
  // Of a substep; of n nodes, n - 1 elements.
  Vector storing_;          // (n) m^3/(Pa s)
  Vector along_, carried_;  // (n - 1) m^3/(Pa s), -: what pressures and the flow before make of a flow
  Vector shunt_;            // (n) m^3/(Pa s)
  double wall_carried_ = 0.0, wall_held_ = 0.0;  // -, 1/s
  Vector inverse_pivots_, down_, up_;            // (n) the factors of the tridiagonal matrix
  // What a flow at the glottis that grows from 0 to 1 m^3/s in the step adds: all is linear in it.
  Vector added_;
  Borders added_borders_;
  double impedance_ = 0.0;
  // Of a step.
  Vector state_, without_;  // as it begins; as it would end without flow at the glottis
  Borders without_borders_;
  double flow_ = 0.0, source_ = 0.0, source_then_ = 0.0, pressure_ = 0.0;
  mutable Vector middle_, flows_, walls_;  // Pa, m^3/s, of the middle of a substep: workspace
};

}  // namespace plica

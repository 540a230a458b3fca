#pragma once
#include <optional>

#include "plica/airflow/gas.hpp"
#include "plica/core/types.hpp"

namespace plica {

/// What presses on the walls of the airway, Pa: below the first section, at the sections, above the last.
struct AirwayPressure {
  double below = 0.0;
  Vector sections;  // (s)
  double above = 0.0;
  /// (s + 2) sections, below, above; and from these.
  Vector all() const;
  static AirwayPressure of(const Vector& all);
  bool same_ends(const AirwayPressure& other) const { return below == other.below && above == other.above; }
};

/// How fast the walls of the airway give way, m^3/s: below the first section, at the sections, above the last.
/// Times AirwayPressure this is the power of the air on them.
struct AirwayExpansion {
  double below = 0.0;
  Vector sections;  // (s)
  double above = 0.0;
  double total() const { return below + sections.sum() + above; }
};

/// What the flow does at one instant.
struct FlowState {
  Vector area;                         // (s) m^2, of each section
  Vector pressure;                     // (s) Pa, at each section
  int separation = 0;                  // first section of the free jet; the last one where it leaves at the exit
  bool stopped = false;                // Bernoulli only: contact inside the middle of the glottis, or no area left
  double subglottal_pressure = 0.0;    // Pa, below the first section
  double supraglottal_pressure = 0.0;  // Pa, in the jet and above the last section
  double flow = 0.0;                   // m^3/s, upwards, through the glottis
  double flow_below = 0.0;  // m^3/s, into the airway from below: the flow and what the walls there make room for
  double flow_above = 0.0;  // m^3/s, out of it above: the flow without what they make room for there
  /// W, the difference of these pressures times flow: the sum of the next three. With inertance the air that walls
  /// displace counts, too, which it then accelerates.
  double supplied_power = 0.0;
  double jet_power = 0.0;       // W, kinetic energy that leaves with the jet
  double viscous_power = 0.0;   // W, lost to friction at the walls
  double inertial_power = 0.0;  // W, what accelerates the air between the sections; 0 without inertance
  Vector momentum;              // (s) Pa s, Phi of ViscousSlit; empty without inertance

  AirwayPressure on_walls() const { return {subglottal_pressure, pressure, supraglottal_pressure}; }
};

/// How fast the momenta Phi (s) Pa s of ViscousSlit change, by a difference to those of the past:
/// dPhi/dt = rate Phi - past.
struct AirInertia {
  double rate = 0.0;  // 1/s
  Vector past;        // (s) Pa
};

/// The air that drives the flow.
struct Air {
  double subglottal_pressure = 800.0;  // Pa, below the first section
  double density = Gas{}.density;      // kg/m^3, > 0
  double supraglottal_pressure = 0.0;  // Pa, above the last section; where it is the larger one, air flows back
  /// Pa s/m^3, what a tube takes from the one and adds to the other for the flow out of and into it: the pressures
  /// above are then those without such flows.
  double subglottal_impedance = 0.0, supraglottal_impedance = 0.0;
  const AirInertia* inertia = nullptr;  // of a slit with inertance; absent where the flow is steady
  double impedance() const { return subglottal_impedance + supraglottal_impedance; }
};

/// The thesis's flow, Paper A, Eqs. (1) and (2): inviscid, separated at the section of least area, stopped by
/// contact in the middle of the glottis. It jumps where the least section changes and where the flow stops.
struct Bernoulli {
  double zero_flow_fraction = 0.5;  // tau of Sec. 2.4, in [0, 1]: contact within tau * y_i of the middle stops it
  void validate() const;            // throws InvalidInput
};

/// A jet that leaves the wall where the glottis has widened to `separation_ratio` times the least area upstream,
/// with the viscous loss of plane Poiseuille flow where it follows the wall. Continuous in all areas; nothing
/// stops it: what is closed is a gap through which next to nothing flows.
struct ViscousSlit {
  /// -, in (1, 2]. 1.1 to 1.3 in the literature (docs/theory/airflow.md).
  double separation_ratio = 1.2;
  double air_viscosity = Gas{}.viscosity;  // Pa s, >= 0
  /// -, in (0, 0.01]: the mean gap below which a section counts as no narrower, in lengths of the glottis. 4 um
  /// for 14 mm: one hundredth of the thesis's least area at rest.
  double least_gap = 3e-4;
  bool inertance = false;  // whether the air between the first and the last section has to be accelerated
  void validate() const;   // throws InvalidInput
};

/// Sections with heights (m, ascending) and anteroposterior lengths (m), as far as a flow knows them.
struct Channel {
  const Vector& height;
  const Vector& length;
};

/// p_i = p_s (1 - (a_min / a_i)^2) upstream of the separation, 0 from there on (Eqs. 1 and 2), above the
/// supraglottal pressure, which the thesis takes as 0; stopped, or a_min <= 0: p_i = p_s upstream, 0 from there
/// on, no flow. Areas up to `closed_area` count as closed where the
/// flow is stopped. With a given `separation` both it and `stopped` are held, whatever the areas: a_min is then
/// the area there (at least 0) and a ratio above 1 counts as 1, so that pressures are continuous in the areas and
/// within [0, p_s]. O(s).
///
/// Both models divide the air that walls displace so that the flow itself takes no power from it: the share (p_i -
/// p_above) / (p_below - p_above) of what makes room at section i comes from below, the rest from above
/// (docs/theory/tubes.md). Without `moving` walls are at rest. With the flows U below and above the pressures
/// there are p_s - Z_s U_below and p_e + Z_e U_above.
FlowState bernoulli_flow(const Air& air, double closed_area, const Vector& areas, bool stopped,
                         std::optional<int> separation = std::nullopt, const AirwayExpansion* moving = nullptr);

/// With the floored area a, its least value upstream m(z), r = separation_ratio, the area of the stream is
/// e = min(a, r m), and
///   p_s = rho U^2 / (2 e_exit^2) + U R,  p(z) = p_s - rho U^2 / (2 e(z)^2) - U R(z),
///   R(z) = integral up to z of 12 mu W^2 s / a^3,
/// the wall's friction factor s falling linearly in a from 1 at a = m to 0 where the stream leaves the wall,
/// a = r m. Areas are linear between sections and R is exact for that. Pressures are above the supraglottal one:
/// 0 in the free jet, and negative where the glottis widens. With D the difference of both pressures,
/// U = 2 D / (R + sqrt(R^2 + 2 rho |D| / e_exit^2)). Air that flows back has the same loss: where its jet would
/// leave the wall is not modelled. Areas are finite, which Airflow::evaluate checks. O(s).
///
/// With inertance the drop from the first section to section i is larger by dPhi_i/dt,
///   Phi_i = L_i U,  L_i = rho integral of dz / a up to section i
/// (docs/theory/airflow.md): U has the resistance rate L_s and the drop past_s more, p_i the resistance
/// rate (L_s - L_i) and the pressure past_i - past_s. U is then the flow of the jet. What walls make room for
/// upstream of the separation is filled from below, where friction does not decide otherwise, and p_i is lower by
/// rho U W_i / e_i^2, W_i being what is filled beyond section i: first order in rates, as dPhi/dt.
FlowState viscous_slit_flow(const ViscousSlit& model, const Air& air, const Channel& channel, const Vector& areas,
                            const AirwayExpansion* moving = nullptr);

}  // namespace plica

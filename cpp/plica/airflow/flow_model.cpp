#include "plica/airflow/flow_model.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"

namespace plica {
namespace {

/// a, but smoothly no less than `floor`: equal from 2 floor on, floor for a <= 0; its slope is within [0, 1].
double floored(double a, double floor) {
  if (a >= 2 * floor) return a;
  return a <= 0 ? floor : floor + a * a / (4 * floor);
}

/// -, s: how much of the stream follows the wall at a >= m, the least area up to there: 1 where a = m, falling
/// linearly in a to 0 where the stream leaves the wall, a = r m.
double attachment(double a, double m, double r) { return std::max(0.0, (r * m - a) / ((r - 1) * m)); }

/// Mean over an interval of s / a^3, a being linear from `from` to `to`: s is 1 where a <= m, the attachment
/// elsewhere. With `share` the part of the interval that has areas in [low, high]:
///   1 / a^3 integrates to share (low + high) / (2 low^2 high^2),   1 / a^2 to share / (low high).
double mean_friction(double from, double to, double m, double r) {
  const double least = std::min(from, to), largest = std::max(from, to);
  const auto share = [=](double low, double high) {
    return largest > least ? (high - low) / (largest - least) : 1.0;
  };
  double mean = 0;
  if (least <= m) {
    const double low = least, high = std::min(largest, m);
    mean += share(low, high) * (low + high) / (2 * low * low * high * high);
  }
  const double low = std::max(least, m), high = std::min(largest, r * m);
  if (low < high || (low == high && least == largest && low > m))
    mean += share(low, high) * (r * (low + high) / (2 * low * high) - 1 / m) / ((r - 1) * low * high);
  return mean;
}

/// Mean over an interval of 1 / a, a being linear from `from` to `to`: log(to / from) / (to - from).
double mean_inverse(double from, double to) {
  constexpr double near = 0.02;  // where the next term of the series is below 1e-14
  const double y = (to - from) / (to + from), yy = y * y;
  if (std::abs(y) < near) return 2 / (from + to) * (1 + yy * (1.0 / 3 + yy * (1.0 / 5 + yy / 7)));
  return std::log(to / from) / (to - from);
}

/// Pa s^2/m^3, L of a ViscousSlit at each section.
Vector inertances(double density, const Vector& height, const Vector& a) {
  Vector L = Vector::Zero(a.size());
  for (std::ptrdiff_t i = 1; i < a.size(); ++i)
    L[i] = L[i - 1] + density * (height[i] - height[i - 1]) * mean_inverse(a[i - 1], a[i]);
  return L;
}

/// Ends of the airway from which a flow U comes and to which it goes, the walls giving way by `displaced`, of
/// which `from_below` comes from below: the drop of pressure that drives U is what is left.
double drop_without_flow(const Air& air, double from_below, double displaced) {
  const double drop = air.subglottal_pressure - air.supraglottal_pressure;
  if (displaced == 0 && from_below == 0) return drop;
  return drop - air.subglottal_impedance * from_below + air.supraglottal_impedance * (displaced - from_below);
}

/// Flows and pressures at the ends.
void set_ends(const Air& air, double from_below, double displaced, FlowState& state) {
  state.flow_below = state.flow + from_below;
  state.flow_above = state.flow - (displaced - from_below);
  state.subglottal_pressure = air.subglottal_pressure;
  state.supraglottal_pressure = air.supraglottal_pressure;
  if (air.subglottal_impedance != 0) state.subglottal_pressure -= air.subglottal_impedance * state.flow_below;
  if (air.supraglottal_impedance != 0)
    state.supraglottal_pressure += air.supraglottal_impedance * state.flow_above;
}

/// m^3/s, of drop = R U + rho U |U| exit / 2.
double flow_of(double drop, double R, double density, double exit) {
  if (drop == 0) return 0;  // which 0 / 0 is not where there is no friction
  return 2 * drop / (R + std::sqrt(R * R + 2 * density * std::abs(drop) * exit));
}

/// What a slit takes of a flow beside its jet: drop + past = (friction + accelerating) U + the jet's.
struct SlitLoss {
  double friction = 0.0;      // Pa s/m^3, R
  double accelerating = 0.0;  // Pa s/m^3, of the inertance
  double past = 0.0;          // Pa
};

/// What walls along a slit displace, and its share of the drop as the flow has it: with the head h = rho |U| / 2
/// the part (h (exit - 1 / e_i^2) + R - R_i) / (h exit + R) of a section comes from below.
struct SlitWalls {
  double below = 0.0, displaced = 0.0;  // m^3/s: below the first section; of all walls
  double head = 0.0, friction = 0.0;    // of the sections: sums of the two parts of the numerator
  double from_below(double h, double exit, double R) const {
    const double drop = h * exit + R;
    return below + (drop > 0 ? (h * head + friction) / drop : head / exit);
  }
};

/// The flow that ends and walls leave; they depend on it in turn, a little, by how much of the drop is friction.
/// The share from below is monotone in |U|, so that the flows of no and of all friction enclose it: it is
/// iterated, and halved from where that does not lead on.
void set_slit_flow(const Air& air, double exit, const SlitLoss& loss, const SlitWalls* walls, FlowState& state) {
  const double R = loss.friction;
  const auto flow_from = [&](double from_below, double displaced) {
    return flow_of(drop_without_flow(air, from_below, displaced) + loss.past,
                   R + loss.accelerating + air.impedance(), air.density, exit);
  };
  if (!walls) {
    state.flow = flow_from(0, 0);
    return set_ends(air, 0, 0, state);
  }
  constexpr int iterated = 20, most = 200;
  const auto from_below_at = [&](double U) { return walls->from_below(0.5 * air.density * std::abs(U), exit, R); };
  double low = flow_from(from_below_at(0), walls->displaced);
  double high = flow_from(walls->below + walls->head / exit, walls->displaced);
  if (low > high) std::swap(low, high);
  double U = low;
  for (int i = 0; i < most; ++i) {
    const double next = flow_from(from_below_at(U), walls->displaced);
    if (std::abs(next - U) <= 1e-14 * (std::abs(next) + std::abs(walls->displaced))) break;
    (next > U ? low : high) = U;
    const double middle = 0.5 * (low + high);
    if (i >= iterated && (middle == low || middle == high)) break;
    U = i < iterated ? next : middle;
  }
  const double from_below = from_below_at(U);
  state.flow = flow_from(from_below, walls->displaced);
  set_ends(air, from_below, walls->displaced, state);
}

/// -, (s) of floored areas a.
Vector attachments(const Vector& a, double r) {
  Vector share(a.size());
  double m = a[0];
  for (std::ptrdiff_t i = 0; i < a.size(); ++i) {
    m = std::min(m, a[i]);
    share[i] = attachment(a[i], m, r);
  }
  return share;
}

/// The pressures and the power that accelerate the air, of a flow whose steady part is known.
void add_inertia(const AirInertia& inertia, FlowState& state) {
  const Vector change = inertia.rate * state.momentum - inertia.past;  // Pa, dPhi/dt
  const double all = change[change.size() - 1];
  state.pressure.array() += all - change.array();
  state.inertial_power = all * state.flow;
}

/// What flows past each section beside U to fill the room that walls make further on makes it faster there; with
/// `share` of what a section makes room for filled so, inverse_squares 1 / e^2. The power that this and inertia
/// take from the walls.
void add_displaced_air(double density, const Vector& share, const Vector& inverse_squares,
                       const AirwayExpansion& moving, FlowState& state) {
  double further = 0;  // m^3/s, W
  for (std::ptrdiff_t i = share.size() - 1; i >= 0; --i) {
    const double own = share[i] * moving.sections[i];
    state.pressure[i] -= density * std::abs(state.flow) * (further + 0.5 * own) * inverse_squares[i];
    further += own;
  }
  const double drop = state.subglottal_pressure - state.supraglottal_pressure;
  const double from_below = state.flow_below - state.flow - moving.below;  // of the sections
  const double displaced =
      drop * from_below - (state.pressure.array() - state.supraglottal_pressure).matrix().dot(moving.sections);
  state.inertial_power += displaced;
  state.supplied_power += displaced;
}

}  // namespace

Vector AirwayPressure::all() const {
  Vector values(sections.size() + 2);
  values << sections, below, above;
  return values;
}

AirwayPressure AirwayPressure::of(const Vector& all) {
  require_at_least("AirwayPressure", "values", all.size(), 2);
  const std::ptrdiff_t count = all.size() - 2;
  return {all[count], all.head(count), all[count + 1]};
}

void Bernoulli::validate() const {
  if (!(zero_flow_fraction >= 0 && zero_flow_fraction <= 1))
    throw InvalidInput("Bernoulli", "zero_flow_fraction", zero_flow_fraction, "", "in [0, 1]");
}

void ViscousSlit::validate() const {
  if (!(separation_ratio > 1 && separation_ratio <= 2))
    throw InvalidInput("ViscousSlit", "separation_ratio", separation_ratio, "", "in (1, 2]",
                       "1.1 to 1.3 are in use.");
  if (!(air_viscosity >= 0 && air_viscosity < 1))
    throw InvalidInput("ViscousSlit", "air_viscosity", air_viscosity, "Pa s", "in [0, 1)",
                       "Air has 1.8e-5. Is the unit right?");
  if (!(least_gap > 0 && least_gap <= 0.01))
    throw InvalidInput("ViscousSlit", "least_gap", least_gap, "", "in (0, 0.01]",
                       "It is a width over the length of the glottis.");
}

FlowState bernoulli_flow(const Air& air, double closed_area, const Vector& areas, bool stopped,
                         std::optional<int> separation, const AirwayExpansion* moving) {
  require_at_least("bernoulli_flow", "areas", areas.size(), 1);
  if (separation) require_index("bernoulli_flow", "separation", *separation, areas.size());
  if (moving) require_size("bernoulli_flow", "moving.sections", moving->sections.size(), areas.size());
  FlowState state;
  state.area = areas;
  std::ptrdiff_t least = 0;
  const double least_area = areas.minCoeff(&least);
  state.stopped = stopped;
  if (separation) {
    state.separation = *separation;
  } else {
    state.stopped = stopped || least_area <= 0;
    // Where the folds touch, several sections are closed to round-off: the flow meets the lowest of them first.
    if (state.stopped)
      least = std::find_if(areas.begin(), areas.end(),
                           [&](double a) { return a <= std::max(least_area, 0.0) + closed_area; }) -
              areas.begin();
    state.separation = static_cast<int>(least);
  }
  const double throat = state.stopped ? 0 : std::max(areas[state.separation], 0.0);
  Vector& share = state.pressure;  // of the drop, then pressures
  share = Vector::Zero(areas.size());
  for (int i = 0; i < state.separation; ++i) {
    const double ratio = throat < areas[i] ? throat / areas[i] : (throat > 0 ? 1.0 : 0.0);
    share[i] = 1 - ratio * ratio;
  }
  const double from_below = moving ? moving->below + share.dot(moving->sections) : 0.0;
  const double displaced = moving ? moving->total() : 0.0;
  double drop = drop_without_flow(air, from_below, displaced);
  if (air.impedance() == 0)
    state.flow = std::copysign(std::sqrt(2 * std::abs(drop) / air.density) * throat, drop);
  else if (throat > 0)
    state.flow = flow_of(drop, air.impedance(), air.density, 1 / (throat * throat));
  set_ends(air, from_below, displaced, state);
  drop = state.subglottal_pressure - state.supraglottal_pressure;
  for (double& pressure : share) pressure = state.supraglottal_pressure + drop * pressure;
  state.supplied_power = state.jet_power = drop * state.flow;
  return state;
}

FlowState viscous_slit_flow(const ViscousSlit& model, const Air& air, const Channel& channel, const Vector& areas,
                            const AirwayExpansion* moving) {
  const std::ptrdiff_t count = areas.size();
  require_at_least("viscous_slit_flow", "areas", count, 1);
  require_size("viscous_slit_flow", "channel.height", channel.height.size(), count);
  require_size("viscous_slit_flow", "channel.length", channel.length.size(), count);
  if (moving) require_size("viscous_slit_flow", "moving.sections", moving->sections.size(), count);
  const double r = model.separation_ratio;
  FlowState state;
  state.area = areas;
  Vector a(count);
  for (std::ptrdiff_t i = 0; i < count; ++i)
    a[i] = floored(areas[i], model.least_gap * channel.length[i] * channel.length[i]);
  const Vector inverse = a.cwiseInverse();  // divisions are what this costs
  Vector& stream = state.pressure;          // 1 / e^2, then pressures
  Vector resistance(count);                 // R, Pa s / m^3
  stream.resize(count);
  state.separation = 0;
  double m = a[0], inverse_m = inverse[0];
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const double least_before = m;
    if (a[i] < m) {
      m = a[i];
      inverse_m = inverse[i];
    }
    const bool attached = a[i] < r * m;
    const double inverse_e = attached ? inverse[i] : inverse_m / r;
    stream[i] = inverse_e * inverse_e;
    if (attached) state.separation = static_cast<int>(std::min(i + 1, count - 1));
    if (i == 0) {
      resistance[i] = 0;
      continue;
    }
    double friction = 0;
    if (a[i - 1] <= least_before && a[i] <= least_before)
      friction = 0.5 * (inverse[i - 1] + inverse[i]) * inverse[i - 1] * inverse[i];
    else if (std::min(a[i - 1], a[i]) < r * least_before)
      friction = mean_friction(a[i - 1], a[i], least_before, r);
    resistance[i] = resistance[i - 1] + 12 * model.air_viscosity * channel.length[i - 1] * channel.length[i] *
                                            (channel.height[i] - channel.height[i - 1]) * friction;
  }
  const double exit = stream[count - 1], total = resistance[count - 1];
  SlitWalls walls;
  Vector share, inverse_squares;  // with inertance and walls that move
  if (moving) {
    walls = {moving->below, moving->total(), (exit - stream.array()).matrix().dot(moving->sections),
             (total - resistance.array()).matrix().dot(moving->sections)};
    if (model.inertance) {
      share = attachments(a, r);
      inverse_squares = stream;
      walls.head = exit * share.dot(moving->sections);
    }
  }
  SlitLoss loss{total};
  Vector inertance;  // L, Pa s^2/m^3
  if (model.inertance) {
    inertance = inertances(air.density, channel.height, a);
    if (air.inertia) {
      require_size("viscous_slit_flow", "air.inertia.past", air.inertia->past.size(), count);
      loss.accelerating = air.inertia->rate * inertance[count - 1];
      loss.past = air.inertia->past[count - 1];
    }
  }
  set_slit_flow(air, exit, loss, moving ? &walls : nullptr, state);
  const double drop = state.subglottal_pressure - state.supraglottal_pressure;
  const double head = 0.5 * air.density * state.flow * std::abs(state.flow);
  stream =
      state.supraglottal_pressure + head * (exit - stream.array()) + state.flow * (total - resistance.array());
  state.supplied_power = drop * state.flow;
  state.jet_power = head * exit * state.flow;
  state.viscous_power = total * state.flow * state.flow;
  if (model.inertance) {
    state.momentum = state.flow * inertance;
    if (air.inertia) add_inertia(*air.inertia, state);
    if (moving) add_displaced_air(air.density, share, inverse_squares, *moving, state);
  }
  return state;
}

}  // namespace plica

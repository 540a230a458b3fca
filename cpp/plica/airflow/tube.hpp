#pragma once
#include <optional>
#include <variant>
#include <vector>

#include "plica/airflow/gas.hpp"

namespace plica {

/// A wall that yields on its own, each part under the pressure there: mass, damping and stiffness of a unit of
/// area. By default that of a relaxed cheek (Ishizaka, French and Flanagan 1975).
struct YieldingWall {
  double mass = 21.0;         // kg/m^2, > 0
  double resistance = 8000;   // Pa s/m, >= 0
  double stiffness = 8.45e5;  // Pa/m, > 0: without it the air would leak through the wall
};

/// The far end is open: the field before a piston in an infinite baffle, a resistance beside an inertance
/// (Ishizaka and Flanagan 1972), R = 128 rho c / (9 pi^2 A), L = 8 rho sqrt(A / pi) / (3 pi A).
struct Radiation {};

/// A pressure that varies by time alone stands behind the far end, which gives back this share of a wave: 1 where
/// it holds the pressure itself, 0 where nothing comes back. The steady flow pays for it: the resistance in
/// between is rho c / A (1 - reflection) / (1 + reflection).
struct PressureSupply {
  double reflection = 1.0;  // in [0, 1]
  double volume = 0.0;      // m^3, >= 0: air at the far end that gives way; 0 with a reflection of 1
};

/// A flow that varies by time alone enters at the far end: closed where it is 0.
struct FlowSupply {
  double volume = 0.0;  // m^3, >= 0
  double flow = 0.0;    // m^3/s, >= 0, from the end of its rise on
};

/// A tube from the glottis to its far end, of parts that are uniform.
struct Tube {
  std::vector<double> length;  // m, > 0, of each part
  std::vector<double> area;    // m^2, > 0
  std::variant<Radiation, PressureSupply, FlowSupply> end = Radiation{};
  std::optional<YieldingWall> wall{};  // absent: rigid
  /// Hz, >= 0: the wall's friction is that of a boundary layer at this frequency; 0: none.
  double friction_frequency = 1000.0;
  void validate(const char* where) const;  // throws InvalidInput
};

/// The tubes of a scene: absent is one of no length, at the end of which the pressure is held.
struct Tubes {
  /// From the first section down. Its end is a supply: of the subglottal pressure, or of a flow that rises as
  /// that.
  std::optional<Tube> trachea;
  std::optional<Tube> tract;               // from the last section up; nothing drives its end
  double sound_speed = Gas{}.sound_speed;  // m/s, > 0
  bool any() const { return trachea || tract; }
  void validate() const;  // throws InvalidInput
};

}  // namespace plica

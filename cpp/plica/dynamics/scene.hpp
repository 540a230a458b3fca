#pragma once
#include <optional>
#include <string>

#include "plica/airflow/airflow.hpp"
#include "plica/contact/collision.hpp"
#include "plica/mesh/tet_mesh.hpp"
#include "plica/solve/supports.hpp"
#include "plica/tissue/assembly.hpp"

namespace plica {

/// The load of the last known positions, x_n, as in the thesis: it lags and feeds energy in.
struct Lagged {};
/// The load of positions extrapolated to t_{n+1+alpha}: second order, one evaluation a step.
struct Extrapolated {};
/// The load of the step's own positions at t_{n+1+alpha}: fixed point, accelerated by Anderson mixing. The load
/// jumps where the section of least area changes or the flow stops, and a fixed point may then not exist: from
/// sweep `freeze_after` on the section of separation and the stop are held for the rest of the step, and the step
/// is counted. One that still has none after `max_sweeps` keeps its last load, of positions that differ by the
/// recorded residual: equilibrium holds, the coupling is that of a lagged load for this step, and it is counted
/// too.
struct Iterated {
  double tolerance = 1e-5;  // -, > 0: largest change of a section's pressure, in subglottal pressures
  int max_sweeps = 40;      // > freeze_after
  int freeze_after = 8;     // >= 1
  void validate() const;    // throws InvalidInput
};
using Coupling = std::variant<Lagged, Extrapolated, Iterated>;

struct AirflowPart {
  std::string surface = "airway";
  Airflow::Options flow;
  Coupling coupling = Iterated{};
};

/// The mass of the nodes of both contact surfaces. Redistributed, they have none, but for those held in all
/// components: it lies with the nodes behind them, and mass, centre of mass and tensor of inertia of every body
/// are as they were. An impact then has no inertia to stop at once (docs/theory.md, "Massless contact nodes").
enum class SurfaceMass { kept, redistributed };

struct ContactPart {
  Airway airway;
  Enforcement enforcement = Multipliers{};
  Collision::Options options;
  std::optional<Friction> friction{};  // absent: frictionless
  SurfaceMass surface_mass = SurfaceMass::kept;
  FaceMethod faces = AtNodes{};
};

/// A traction on a named surface of the reference shape: traction * cos(2 pi frequency t + phase).
struct Load {
  std::string surface;
  Vector3 traction = Vector3::Zero();  // Pa
  double frequency = 0.0;              // Hz, >= 0
  double phase = 0.0;                  // rad
  void validate() const;               // throws InvalidInput
};

/// What is simulated. A part without a value does not exist: nothing of it is built or looked at.
struct Scene {
  TetMesh mesh;
  Tissue tissue;
  Supports supports;
  std::optional<AirflowPart> airflow;
  std::optional<ContactPart> contact;
  std::vector<Load> loads;
  std::optional<Vector3> gravity;      // m/s^2
  std::optional<Points> displacement;  // (n, 3) m at t = 0
  std::optional<Points> velocity;      // (n, 3) m/s at t = 0
  void validate() const;               // throws InvalidInput: the mesh, and all that must fit it
};

}  // namespace plica

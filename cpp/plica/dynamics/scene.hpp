#pragma once
#include <optional>
#include <string>

#include "plica/airflow/air_column.hpp"
#include "plica/airflow/airflow.hpp"
#include "plica/contact/collision.hpp"
#include "plica/dynamics/coupling.hpp"
#include "plica/dynamics/finite_strain.hpp"
#include "plica/dynamics/reduction.hpp"
#include "plica/mesh/mirror.hpp"
#include "plica/mesh/tet_mesh.hpp"
#include "plica/solve/supports.hpp"
#include "plica/tissue/assembly.hpp"

namespace plica {

struct AirflowPart {
  std::string surface = "airway";
  Airflow::Options flow;
  Coupling coupling = Iterated{};
  /// Lagged and extrapolated loads are not stable between tubes unless steps are much shorter than usual ones: the
  /// air that folds displace answers within the step. Iterated ones are.
  Tubes tubes{};
  void validate() const;  // throws InvalidInput: the coupling, and what of it must fit the flow
};

/// The mass of the nodes of both contact surfaces. Redistributed, they have none, but for those held in all
/// components: it lies with the nodes behind them; centre of mass and tensor of inertia of bodies that can move
/// without strain are as they were. An impact then has no inertia to stop at once (docs/theory/massless.md).
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
  std::optional<Reduction> reduction{};
  /// Mesh, tissue, supports, loads and initial values are symmetric, and the motion is to stay so: half or a
  /// quarter of the tissue is solved for. Absent: all of it.
  std::optional<Symmetry> symmetry{};
  std::optional<FiniteStrain> strain{};  // absent: tissue is linear about the mesh's shape
  void validate() const;                 // throws InvalidInput: the mesh, and all that must fit it
};

}  // namespace plica

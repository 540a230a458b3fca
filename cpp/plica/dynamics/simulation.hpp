#pragma once
#include <memory>
#include <optional>

#include "plica/dynamics/explicit_motion.hpp"
#include "plica/dynamics/motion.hpp"
#include "plica/dynamics/record.hpp"
#include "plica/dynamics/reduced_model.hpp"
#include "plica/dynamics/scene_contact.hpp"
#include "plica/dynamics/scene_flow.hpp"
#include "plica/dynamics/scene_loads.hpp"
#include "plica/dynamics/state.hpp"
#include "plica/dynamics/state_products.hpp"
#include "plica/dynamics/tissue_watch.hpp"

namespace plica {

/// Steps a scene through time. The caller owns the loop:
///
///   Simulation simulation(scene, {HilberHughesTaylor{}, 50e-6});
///   while (simulation.time() < 0.1) simulation.advance();
class Simulation {
 public:
  using Mass = CellMass;
  using Options = Motion::Options;

  /// Assembles and solves for the initial acceleration. Throws InvalidInput.
  Simulation(Scene scene, Options options);
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// One step. Throws SolveFailed with time, cause and what went wrong before it (State::first_signs); the state
  /// is then that of the last completed step.
  void advance();

  double time() const { return static_cast<double>(state_.step) * motion_.step(); }
  const State& state() const { return state_; }
  /// Continues from a state of a simulation of the same scene and options: the steps that follow are identical
  /// (an external force is not part of it). record() is empty until the next step. Throws InvalidInput, also for
  /// a state whose products, K v and so on, are not those of its displacement, velocity and acceleration.
  void restore(State state);
  /// A state whose velocity, acceleration or, without contact, displacement the embedder has changed, with its
  /// products made anew, for restore(). The energy that the change brings counts as the ledger's `initial`; forces
  /// and accelerations of the last step stay as they were. Throws InvalidInput.
  State renewed(State state) const;
  const StepRecord& record() const { return record_; }  // of the last step
  StepTimes times() const;

  const Scene& scene() const { return scene_; }
  const Options& options() const { return motion_.options(); }
  /// Matrices and state() are of the unknowns that are solved for: (3 n) of all nodes, or (3 p) of the part of a
  /// symmetric scene, S^T M S and so on, so that energies are those of the whole. images() has the part's nodes,
  /// and gives the matrix of all nodes: images()->unfolded(stiffness().to_sparse()).
  const NodalMatrix& mass() const { return motion_.mass(); }
  const BlockMatrix& stiffness() const { return motion_.stiffness(); }
  /// Absent where no material is viscous.
  const std::optional<BlockMatrix>& viscosity() const { return motion_.viscosity(); }
  const Supports& supports() const { return motion_.supports(); }
  /// Null unless the scene is symmetric.
  const MirrorImages* images() const { return motion_.images(); }
  /// Throws InvalidInput with CentralDifferences and in a reduced scene, which have none.
  const BlockMatrix& step_matrix() const { return motion_.step_matrix(); }
  /// "Cholesky" or "conjugate gradients": what solves the step's linear systems; "none" with CentralDifferences
  /// and in a reduced scene, which have none.
  std::string linear_solver() const { return motion_.solves() ? motion_.solver().name() : "none"; }
  /// s, the largest that CentralDifferences take; absent with other schemes, which take any.
  std::optional<double> largest_step() const {
    return explicit_ ? std::optional(explicit_->largest_step()) : std::nullopt;
  }
  /// Null without airflow.
  const Airflow* airflow() const { return flow_ ? &flow_->airflow() : nullptr; }
  /// Null without airflow. What it remembers of the last step is state().air.
  const AirColumn* air_column() const { return air_ ? &*air_ : nullptr; }
  /// Of all nodes, whatever moves them. Null without contact.
  const Collision* collision() const { return contact_ ? &contact_->collision() : nullptr; }
  /// How contact forces are solved for, never Automatic; null without contact, with CentralDifferences and in a
  /// reduced scene.
  const ContactSolver* contact_solver() const {
    return contact_ && contact_->solver() ? &*contact_->solver() : nullptr;
  }

  /// Null where the scene is not reduced.
  const ReducedModel* reduced() const { return reduced_ ? &*reduced_ : nullptr; }

  /// (n, 3) m, current positions.
  Points positions() const;
  /// (3 n) m, m/s, m/s^2, N at all nodes, of a reduced or a symmetric motion, too.
  Vector displacement() const { return at_nodes(state_.displacement); }
  Vector velocity() const { return at_nodes(state_.velocity); }
  Vector acceleration() const { return at_nodes(state_.acceleration); }
  Vector contact_force() const;
  /// (p, 3) m of these nodes.
  Points displacement_of(const Indices& nodes) const;
  /// (s, 3) m, the points of the flow's sections in the mid-coronal plane, of the right or of the left fold.
  Points coronal(Side side) const;
  /// (n) Pa, contact force over area at the nodes of the contact surfaces (Collision::pressure); zero elsewhere.
  Vector contact_pressure() const;
  /// A nodal force (3 n) N of the embedder's own, held until it is replaced; adds to the scene's loads from
  /// the next step on. Like them it counts at t + (1 + alpha) h of the step from t = time() to t + h: with Newmark
  /// (alpha = 0) at its end, so give its value of then. Not part of State, so set it again after restore; not in
  /// the initial acceleration. Throws InvalidInput for another size, for an entry that is not finite, and where
  /// the scene is symmetric and the force is not.
  void set_external_force(Vector force);

 private:
  void begin();
  State::Shape shape_of_states() const;
  StateProducts products_of_states() const;
  void advance_reduced();
  Vector at_nodes(const Vector& unknowns) const {
    return motion_.everywhere(reduced_ ? reduced_->motion().at_unknowns(unknowns) : unknowns);
  }
  std::unique_ptr<NodalStep> begun_step(const Vector& scene_load);
  /// Keeps the state that a completed step led to, and says what it was like.
  void keep(State now, const std::optional<FlowRecord>& flow, const Vector& scene_load, NodalStep& step);

  Scene scene_;
  std::optional<SymmetricPart> part_;
  Assembler assembler_;
  TissueWatch tissue_;
  Motion motion_;
  std::optional<ExplicitMotion> explicit_;
  SceneLoads loads_;
  std::optional<SceneFlow> flow_;
  std::optional<AirColumn> air_;
  Coupling coupling_;
  std::optional<SceneContact> contact_;
  std::optional<ReducedModel> reduced_;
  Indices seen_;  // nodes whose positions flow and contact look at
  State state_;
  State next_state_;  // reduced: memory for the next step's
  StepRecord record_;
  StepTimes times_;
  double detection_of_records_ = 0.0;  // s, what of the detector's time is in times_.record
};

}  // namespace plica

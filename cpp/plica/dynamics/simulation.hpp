#pragma once
#include <memory>

#include "plica/dynamics/anderson.hpp"
#include "plica/dynamics/overlap.hpp"
#include "plica/dynamics/record.hpp"
#include "plica/dynamics/scene.hpp"
#include "plica/dynamics/scheme.hpp"
#include "plica/dynamics/start.hpp"
#include "plica/dynamics/state.hpp"
#include "plica/solve/krylov.hpp"
#include "plica/tissue/node_stress.hpp"

namespace plica {

/// Steps a scene through time. The caller owns the loop:
///
///   Simulation simulation(scene, {HilberHughesTaylor{}, 50e-6});
///   while (simulation.time() < 0.1) simulation.advance();
class Simulation {
 public:
  using Mass = CellMass;
  struct Options {
    TimeScheme scheme = HilberHughesTaylor{};
    double step = 50e-6;   // s, > 0
    KrylovOptions solver;  // of the step's linear systems
    Mass mass = Mass::consistent;
    void validate() const;
  };

  /// Assembles and solves for the initial acceleration. Throws InvalidInput.
  Simulation(Scene scene, Options options);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// One step. Throws SolveFailed with time, cause and what went wrong before it (State::first_signs); the state
  /// is then that of the last completed step.
  void advance();

  double time() const { return static_cast<double>(state_.step) * options_.step; }
  const State& state() const { return state_; }
  /// Continues from a state of a simulation of the same scene and options: the steps that follow are identical
  /// (an external force is not part of it). record() is empty until the next step. Throws InvalidInput.
  void restore(State state);
  const StepRecord& record() const { return record_; }  // of the last step
  StepTimes times() const;

  const Scene& scene() const { return scene_; }
  const Options& options() const { return options_; }
  const NodalMatrix& mass() const { return mass_; }
  const BlockMatrix& stiffness() const { return stiffness_; }
  /// Absent where no material is viscous.
  const std::optional<BlockMatrix>& viscosity() const { return viscosity_; }
  const BlockMatrix& step_matrix() const { return step_matrix_; }
  /// Absent without airflow.
  const std::optional<Airflow>& airflow() const { return airflow_; }
  /// Absent without contact.
  const std::optional<Collision>& collision() const { return collision_; }

  /// How contact forces are solved for, never Automatic; absent without contact.
  const std::optional<ContactSolver>& contact_solver() const { return contact_solver_; }

  /// (n, 3) m, current positions.
  Points positions() const;
  /// (n) Pa, contact force over area at the nodes of the contact surfaces (Collision::pressure); zero elsewhere.
  Vector contact_pressure() const;
  /// A nodal force (3 n) N of the embedder's own, held until it is replaced; adds to the scene's loads from
  /// the next step on. Like them it counts at t + (1 + alpha) h of the step from t = time() to t + h: with Newmark
  /// (alpha = 0) at its end, so give its value of then. Not part of State, so set it again after restore; not in
  /// the initial acceleration.
  void set_external_force(Vector force);

 private:
  struct Step;  // the quantities of one step in the making

  /// Inside, positions are counted from origin_: far from 0, sums of coordinates and displacements would lose
  /// digits that gaps need.
  Points positions_from_origin() const { return reference_ + as_points(state_.displacement); }
  Points in_scene(const Points& x) const { return x.rowwise() + origin_.transpose(); }
  Vector flow_areas(const Points& x) const {  // the flow knows the scene's coordinates
    return origin_.isZero(0) ? airflow_->areas(x) : airflow_->areas(in_scene(x));
  }

  // step.cpp: how a step finds its loads, contacts and acceleration
  void solve(Step& step, const Vector& force, Vector& a);
  void move(Step& step);
  void complete(Step& step);
  void couple(Step& step);
  void iterate(Step& step, const Iterated& coupling);
  void load_by_flow(Step& step, const Points& x, const Vector& pressure);
  bool flow_blocked(const Step& step);
  Points extrapolated_positions(const Step& step) const;
  // simulation.cpp and record.cpp: what is kept of it
  void start_apart();
  Vector scene_load(double t) const;
  void finish(Step& step);
  void update_ledger(const State& before);
  Contact kept_contact() const { return {state_.contact_force, state_.closed, state_.closed_force}; }
  void update_contact_pressure(const Points& x);
  ContactRecord contact_record(const Step& step, const Points& x);

  Scene scene_;
  Options options_;
  SchemeCoefficients scheme_;
  Vector3 origin_;    // m, zero but for meshes far from it
  Points reference_;  // (n, 3) m, from origin_
  Assembler assembler_;
  std::vector<std::int32_t> massless_;  // nodes, ascending; none unless the scene's contact asks for it
  NodalMatrix mass_;
  BlockMatrix stiffness_;
  std::optional<BlockMatrix> viscosity_;
  BlockMatrix step_matrix_;
  ConjugateGradient solver_;
  std::optional<Airflow> airflow_;
  std::optional<ContactSolver> contact_solver_;
  std::optional<Collision> collision_;
  std::optional<TissueOverlap> overlap_;   // with contact
  std::optional<NodeStress> node_stress_;  // with Nitsche's method
  std::vector<Vector> load_vectors_;       // (3 n) N of each Load at amplitude 1
  Vector constant_load_;                   // (3 n) N: gravity
  Vector external_force_;                  // (3 n) N, or empty
  Start start_;                            // of the first step
  State state_;
  Vector contact_pressure_;  // (n) Pa
  StepRecord record_;
  StepTimes times_;
};

}  // namespace plica

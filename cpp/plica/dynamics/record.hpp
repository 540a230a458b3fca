#pragma once
#include <optional>

#include "plica/airflow/airflow.hpp"
#include "plica/tissue/strain.hpp"

namespace plica {

/// What the flow did in a step, at t_{n+1+alpha} (lagged: t_n).
struct FlowRecord {
  FlowState state;
  int sweeps = 0;
  /// Largest pressure change of the last sweep, in subglottal pressures; of a coupling that does not iterate by
  /// how much the pressures it took differ from those of where the step has come to.
  double residual = 0.0;
  bool frozen = false;    // separation and stop were held
  bool converged = true;  // residual within the tolerance; if not, the step is one under a load that lags by it
};

/// What contact did in a step, at x_{n+1}.
struct ContactRecord {
  /// N, the nodal contact forces of the step summed over each side, held nodes included; a node common to both
  /// sides counts half for either.
  Vector3 force_first = Vector3::Zero(), force_second = Vector3::Zero();
  int rows = 0;  // closed constraints
  int passes = 0;
  int pivots = 0;
  int augmentations = 0;             // of Uzawa's iteration
  double gap_error = 0.0;            // m, largest left
  bool converged = true;             // false where passes or augmentations left a gap error above the tolerance
  bool facing = false;               // nodes were held apart from those they face at rest: passes failed
  double slide = 0.0;                // -, largest of a closed slave (Detector::slide), in mean edges
  double friction_loss = 0.0;        // J, minus the work of friction in the step
  double area = 0.0;                 // m^2, mean of both sides' loaded tributary areas
  double length = 0.0;               // m, anteroposterior; a node stands for half the way to its neighbours
  double peak_pressure = 0.0;        // Pa, largest of a pressed node or mean (Collision::pressed)
  double deepest_gap = 0.0;          // m, <= 0: worst confirmed node gap, or depth of a node in the other's tissue
  double overlap_volume = 0.0;       // m^3, inverted tetrahedra with a confirmed slave
  double edge_overlap_volume = 0.0;  // m^3, crossed edges
  /// N, largest -f . n of the nodal contact force f at a slave node with its pair's normal n at x_{n+1} (mortar
  /// faces: of minus a constraint's force): <= 0 where none is pulled towards the other side.
  double largest_multiplier = 0.0;
};

/// One step as it was.
struct StepRecord {
  double time = 0.0;          // s, of the new state
  int iterations = 0;         // of the linear solver, over all solves of the step
  int force_evaluations = 0;  // of tissue at finite strain
  int inverted_tissue = 0;    // tissue cells inside out or folded over, judged at their nodes
  Indices inverted_by_layer;  // (layers) of these
  Strains strains;            // of the new state
  std::optional<FlowRecord> flow;
  std::optional<ContactRecord> contact;
};

/// Seconds spent since construction, by part.
struct StepTimes {
  double residual = 0.0;   // predictors and inner forces
  double load = 0.0;       // sections, pressure, surface traction
  double solve = 0.0;      // the linear solver, and the products that check it
  double tissue = 0.0;     // its force at finite strain
  double detection = 0.0;  // inverted tetrahedra, candidates, pairs
  double contact = 0.0;    // the forces of these pairs
  double ledger = 0.0;     // products and sums of the energy ledger
  double record = 0.0;     // contact measures, strains, inverted tissue
};

}  // namespace plica

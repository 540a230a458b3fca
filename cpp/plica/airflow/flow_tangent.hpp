#pragma once
#include "plica/airflow/airflow.hpp"

namespace plica {

/// How the flow through resting walls answers to small changes of the areas a and of the drop D of pressure
/// between its ends, p_below - p_above: dp_i = dp_above + sum_j pressure_by_area(i, j) da_j + pressure_by_drop(i)
/// dD, dU = flow_by_area . da + flow_by_drop dD.
struct FlowTangent {
  FlowState state;                   // what changes
  Eigen::MatrixXd pressure_by_area;  // (s, s) Pa/m^2
  Vector pressure_by_drop;           // (s) -
  Vector flow_by_area;               // (s) m/s
  double flow_by_drop = 0.0;         // m^3/(Pa s)
  /// Of a slit with inertance, dPhi = momentum_by_area da + momentum_by_drop dD; empty without.
  Eigen::MatrixXd momentum_by_area;       // (s, s) Pa s/m^2
  Vector momentum_by_drop;                // (s) s
  Eigen::MatrixXd pressure_by_expansion;  // (s, s) Pa s/m^3, of the rates at which walls make room
  Vector from_below;  // (s) -, theta: the part of what a section makes room for that is from below
  /// -: the largest difference between the two one-sided derivatives of a section's pressure, in drops of pressure
  /// a relative change of an area. Where it is not small the flow has a kink, and no tangent.
  double kink = 0.0;
};

/// By central differences of Airflow::evaluate over 1e-6 of each area, with the separation of Bernoulli's flow
/// held: off by some 1e-9 where the flow has no kink. Throws InvalidInput. O(s^2).
FlowTangent flow_tangent(const Airflow& airflow, const Vector& areas, const Air& air);

}  // namespace plica

#pragma once
#include "plica/airflow/airflow.hpp"
#include "plica/dynamics/motion.hpp"

namespace plica {

/// Y = A^-1 B: the accelerations (m/s^2 a Pa) that pressures at the sections of a flow cause in a step, B the load
/// of Airflow::load_patterns, A the step matrix. One column a section, and with ends one below, one above the
/// sections; solved for once.
class PressureResponse {
 public:
  /// `nodes`: where displace() is asked for. Throws SolveFailed.
  PressureResponse(const Airflow& airflow, const Motion& motion, Indices nodes, bool ends = false);

  /// Whether it has those of the ends.
  bool ends() const { return ends_; }
  /// What it takes of the difference of two pressures: of the sections, and of the ends where it has them.
  Vector difference(const AirwayPressure& one, const AirwayPressure& other) const;
  /// Adds scale Y p at the nodes to x (n, 3); p Pa, as many as columns.
  void displace(const Vector& pressure, double scale, Points& x) const;
  /// Adds Y p to a, of the motion's unknowns, in single precision.
  void add(const Vector& pressure, Vector& a) const;

 private:
  const MirrorImages* images_;
  Indices nodes_;
  bool ends_;
  std::ptrdiff_t least_rows_;   // of x: one more than the largest of them
  Indices own_;                 // those of the motion's that they are, or are images of
  Indices place_;               // (nodes) in own_
  Eigen::MatrixXd at_nodes_;    // (3 own, s)
  Eigen::MatrixXf everywhere_;  // (unknowns, s)
};

}  // namespace plica

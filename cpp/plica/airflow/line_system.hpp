#pragma once
#include <Eigen/Core>

#include "plica/airflow/transmission_line.hpp"

namespace plica {

/// A line as a linear system, E x' = A x + e_0 U + b S, p = x_0, of the flow U into it, the pressure p there, and
/// the source S at its far end: x^T E x / 2 is its energy, and x^T A x <= 0 what it loses. Its impedance at a
/// complex frequency s is e_0^T (s E - A)^-1 e_0.
struct LineSystem {
  Vector storage;         // (m) the diagonal of E, > 0
  Eigen::MatrixXd rates;  // (m, m) A
  Vector outflow;         // (m) c: the flow out of the far end is c . x, of a source at rest
  Vector source;          // (m) b; 0 of a radiating end, which has none
};

/// x: pressures of the nodes, but for one that is held, flows of elements, of yielding walls flows and volumes, of
/// a radiating end the flow of its inertance.
LineSystem line_system(const TransmissionLine& line);

}  // namespace plica

#pragma once
#include <memory>

#include "plica/contact/constraint.hpp"
#include "plica/contact/pairs.hpp"

namespace plica {

/// A constraint for each slave node (docs/theory/contact.md, "Pair"); key: the node. The detector must outlive it.
std::unique_ptr<ConstraintKind> node_pairs(Detector& detector);

/// A constraint for each inverted airway tetrahedron with one node on one side (Paper A, Eq. 28); key: the
/// tetrahedron. kappa, N/m^3.
std::unique_ptr<ConstraintKind> volume_pairs(Detector& detector, double kappa);

}  // namespace plica

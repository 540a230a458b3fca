#pragma once
#include <memory>

#include "plica/contact/constraint.hpp"
#include "plica/contact/pairs.hpp"

namespace plica {

/// A constraint for each corner of the slave side's faces, on the average around it
/// (docs/theory/contact_faces.md): with the hat psi_i, linear on the three- or six-node faces, the force p_i acts
/// as the traction p_i psi_i / int psi_i dA, carried to the nodes of both sides by the faces' shape functions, and
/// the gap is the average weighted by psi_i. Integrals run over what the two sides' triangles share. Key: the
/// corner. first, second (f, 3 or 6): faces whose flat triangles are those of the detector's surfaces; throws
/// InvalidInput where they are not. The detector must outlive it.
std::unique_ptr<ConstraintKind> mortar_averages(Detector& detector, Faces first, Faces second);

}  // namespace plica

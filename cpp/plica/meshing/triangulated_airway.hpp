#pragma once
#include "plica/contact/airway.hpp"

namespace plica {

/// The airway between any two surfaces, whatever their meshes: Delaunay tetrahedra (CGAL, under the GPL) of the
/// nodes of both, made anew at the beginning of each step. Throws InvalidInput for an empty surface, a position
/// that is not finite, or where no air joins the two. O(n log n) for the n nodes of surfaces, in practice.
Airway triangulated_airway(const Points& points, const Triangles& first, const Triangles& second);

}  // namespace plica

#pragma once
#include <random>

#include "plica/dynamics/scene.hpp"

/// Two smooth convex bodies with meshes that have nothing in common, thrown at each other.
namespace convex {

using namespace plica;

/// A near-ellipsoid of 40 to 90 surface nodes, turned at random, its half-axes 0.6 to 1.2 times 8 mm: nodes on the
/// surface and on two shells inside, joined by Delaunay tetrahedra (CGAL), but for flat ones of the hull. Its
/// boundary is the surface "skin".
TetMesh body(std::mt19937& random);

/// Two of them 0.05 to 0.5 mm apart along x, up to 0.35 radii off each other's axis, that close with `speed`
/// (m/s): 20 kPa, Poisson's ratio 0.3, free in space; multipliers on a triangulated airway, the bodies' cells in
/// `cells`.
Scene thrown(unsigned seed, double speed, std::array<Cells, 2>& cells);

/// One of them and its mirror image 0.1 mm apart, node i's image being node i + n / 2, with a matched airway
/// between what faces the other.
Scene mirrored(unsigned seed, double speed);

}  // namespace convex

#pragma once
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

class ContactSurface;

/// Tetrahedra of air at positions x (n, 3) between two surfaces that are up to date there and at most `depth` (m)
/// inside each other.
using Triangulate = Tets (*)(const Points& x, const ContactSurface& first, const ContactSurface& second,
                             double depth);

/// Two surfaces that may touch, and the tetrahedra of air that join them without inner nodes.
/// Air tetrahedra are positive as long as they are not turned inside out.
struct Airway {
  Triangles first;                   // outward, e.g. the left fold
  Triangles second;                  // outward, e.g. the right fold
  Tets tets;                         // nodes of the tissue mesh only
  Triangulate renewed = nullptr;     // makes the tetrahedra of a new step; null where they never change
  Vector3 facing = Vector3::Zero();  // along which nodes face each other at rest; zero where that is not known
};

/// Nodes of both surfaces, ascending.
std::vector<std::int32_t> surface_nodes(const Airway& airway);

/// The airway between two structured surfaces whose nodes face each other along `direction`: node pairs have
/// the same position across it (to 1e-6 of the extent). Each facing pair of triangles spans a prism, cut
/// into three tetrahedra conforming to its neighbours; a node common to both surfaces closes the prism.
/// Throws InvalidInput naming the first node without a partner.
Airway matched_airway(const Points& points, const Triangles& first, const Triangles& second,
                      const Vector3& direction);

/// Tetrahedra that are turned inside out at positions x, by CGAL's exact orientation predicate;
/// flat ones do not count. O(tets).
std::vector<std::int32_t> find_inverted(const Points& x, const Tets& tets);
/// Of those `among`, numbers of tetrahedra whose nodes are of x.
std::vector<std::int32_t> find_inverted(const Points& x, const Tets& tets, const std::vector<std::int32_t>& among);

}  // namespace plica

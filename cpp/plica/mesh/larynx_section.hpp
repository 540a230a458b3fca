#pragma once
// The half section y = 0 of the triangulated larynx, between profile and wall.

#include <array>
#include <vector>

#include "plica/mesh/edges.hpp"
#include "plica/mesh/larynx.hpp"
#include "plica/mesh/larynx_parts.hpp"

namespace plica {

/// Where a vertex of the half section lies; points are (x, z).
struct SectionVertex {
  double z, minor;
  double depth;  // 0 airway, 1 cover | ligament, 2 ligament | body, 3 wall; linear in between
  bool airway, wall, end, layer;
};

struct HalfSection {
  std::vector<SectionVertex> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;  // counter-clockwise seen against y
  std::vector<std::int32_t> layers;                    // of the triangles: 0 body, 1 ligament, 2 cover
  std::vector<Edge> airway;                            // its edges on the profile, ascending
};

/// How deep cover and ligament are on a line of that length.
LayerDepths depths_on_line(const LayerDepths& depths, double length);

/// Triangulates the half section with edges of the sizes asked for, the layers' surfaces being lines of it.
HalfSection half_section(const Larynx::Shape& shape, const Larynx::Triangulated& how);

}  // namespace plica

#pragma once
#include "plica/mesh/larynx.hpp"

namespace plica {

/// The most that cover and ligament each take of the tissue's depth.
inline constexpr double deepest_layer = 0.3;

/// Thickness of cover and ligament along the level line outward at a height, m.
struct LayerDepths {
  double cover, ligament;
};

/// How thick the layers are at each height in the plane y = 0; beyond the sections they lie between, as there.
class LarynxLayers {
 public:
  explicit LarynxLayers(const Larynx::Shape& shape);
  LayerDepths at(double z) const;
  /// Heights at which the outer surface of that layer bends, its ends included, ascending. 1: cover, 2: ligament.
  std::vector<double> bends(int layer) const;

 private:
  struct Bend {
    double z, x;
  };
  Larynx::Shape shape_;
  std::vector<Bend> cover_, ligament_;  // their outer surfaces
  std::optional<LayerDepths> level_;    // m, thickness where it is measured level
};

/// The minor half-axis at a height within the sections.
double minor_at(const Larynx::Shape& shape, double z);

/// The two ways; `shape` and `how` are valid.
TetMesh mesh_in_levels(const Larynx::Shape& shape, const Larynx::Levels& how);
TetMesh mesh_triangulated(const Larynx::Shape& shape, const Larynx::Triangulated& how);
TetMesh quadratic_mesh_triangulated(const Larynx::Shape& shape, const Larynx::Triangulated& how);

/// Names the surfaces and node sets of a larynx from marks of its nodes.
struct LarynxMarks {
  std::vector<char> airway, wall, end;
};
void name_larynx_parts(const LarynxMarks& marks, TetMesh& mesh);

}  // namespace plica

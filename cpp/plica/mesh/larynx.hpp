#pragma once
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

/// The parametric larynx of Paper A, Sec. 3 (Tables II and III): elliptic airway sections inside a
/// cylinder, both folds, layered, structured, linear tetrahedra (see to_quadratic).
/// Mesh lines run around the airway (matched left to right), outward through cover, ligament and body,
/// and upward in levels. Mirror symmetric in x to the last bit, diagonals included.
/// Surfaces: "airway_left", "airway_right" (the tips y = +-major are in both by their nodes), "airway"
/// (both). Node sets: "wall" (outer cylinder), "ends" (lowest and highest level).
struct Larynx {
  struct Section {
    double z;      // m
    double minor;  // m, half-axis |x|, > 0
  };
  /// Table II: S0 S7 S8 S12 S17 S18 S26 S27 S36 S43 S51.
  std::vector<Section> sections = thesis_sections();
  double major = 0.7e-2;          // m, half-axis y of every section
  double radius = 0.8e-2;         // m, embedding cylinder
  double layer_thickness = 0.05e-2;  // m, of cover and of ligament
  int layers_from_section = 4;    // S17: cover and ligament lie between these two sections
  int layers_to_section = 7;      // S27
  /// Subdivisions between consecutive sections (one fewer than sections).
  std::vector<int> levels = {2, 1, 1, 2, 1, 4, 1, 2, 2, 2};
  int around = 12;                // mesh lines around the airway, a multiple of 4, >= 8
  int cover_rings = 1;            // >= 1
  int ligament_rings = 1;         // >= 1
  int body_rings = 2;             // >= 1, graded outward
  void validate() const;

  static std::vector<Section> thesis_sections();
};

TetMesh larynx_mesh(const Larynx& larynx);

}  // namespace plica

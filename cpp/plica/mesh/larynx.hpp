#pragma once
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

/// The parametric larynx of Paper A, Sec. 3 (Tables II and III): elliptic airway sections inside a
/// cylinder, both folds, layered, structured, linear tetrahedra (see to_quadratic).
/// Mesh lines run around the airway (matched left to right), outward through cover, ligament and body,
/// and upward in levels. Mirror symmetric in x to the last bit, diagonals included (and so in y).
/// Surfaces: "airway_left", "airway_right" (the tips y = +-major are in both by their nodes), "airway"
/// (both). Node sets: "wall" (outer cylinder), "ends" (lowest and highest level).
/// Printed as -0.05 cm in Table II, the minor axis of S27 is taken as +0.05 cm; the length is that of the
/// table, 4 cm, not the 2 cm of the text. The defaults are the coarse preset.
struct Larynx {
  struct Section {
    double z;      // m
    double minor;  // m, half-axis |x|, > 0 and < radius
  };
  /// Table II: S0 S7 S8 S12 S17 S18 S26 S27 S36 S43 S51.
  std::vector<Section> sections = thesis_sections();
  double major = 0.7e-2;             // m, half-axis y of every section, > 0 and < radius
  double radius = 0.8e-2;            // m, embedding cylinder
  double layer_thickness = 0.05e-2;  // m, > 0, of cover and of ligament; at most 0.3 of the tissue's depth each
  int layers_from_section = 4;       // S17: cover and ligament lie between these two sections
  int layers_to_section = 7;         // S27
  /// Subdivisions between consecutive sections (one fewer than sections), each >= 1, at least two in all.
  /// Even, but graded in the first and last interval of three or more: from the glottis outward the heights
  /// are h, h q, h q^2, ..., q in [1, 3] such that h comes nearest to the neighbouring interval's height.
  std::vector<int> levels = {2, 1, 1, 1, 1, 4, 1, 1, 1, 1};
  /// Mesh lines around the airway, a multiple of 4, >= 8. Between the plane y = 0 (s = 0) and the tip (s = 1)
  /// they leave the ellipse at y = major (s + sin(pi s / 2)) / 2 and reach the cylinder at the angle pi s / 2.
  int around = 12;
  int cover_rings = 1;     // >= 1
  int ligament_rings = 1;  // >= 1
  /// >= 1; thicknesses h, h q, h q^2, ... outward, q in [1, 3] such that h comes nearest to the ligament rings'.
  int body_rings = 2;
  void validate() const;
  /// The same larynx with `factor` times the levels, lines and rings: factor^3 times the tetrahedra.
  Larynx refined(int factor) const;

  static std::vector<Section> thesis_sections();
  static Larynx coarse();  // 4032 tetrahedra, 900 nodes
  static Larynx demo();    // 7296 tetrahedra; of quadratic ones the coarsest on which the folds close
  static Larynx medium();  // 19440 tetrahedra, 4032 nodes
  /// 52 levels as in the thesis, at its 52 sections except in the first and last interval, where they are graded:
  /// 55080 tetrahedra (54984 in Paper A, Sec. 3), 11232 nodes.
  static Larynx thesis();
};

/// The mesh; throws InvalidInput where the options are out of range or a cell would be turned inside out.
TetMesh larynx_mesh(const Larynx& larynx);

}  // namespace plica

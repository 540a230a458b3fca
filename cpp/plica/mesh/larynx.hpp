#pragma once
#include <optional>
#include <variant>

#include "plica/mesh/tet_mesh.hpp"

namespace plica {

/// The parametric larynx of Paper A, Sec. 3 (Tables II and III): elliptic airway sections inside a
/// cylinder, both folds, layered; and how it is meshed.
/// Mirror symmetric in x to the last bit, diagonals included (and so in y). Mesh lines run around the airway, its
/// nodes lie on them at the same heights on every line, matched left to right.
/// Surfaces: "airway_left", "airway_right" (the tips y = +-major are in both by their nodes), "airway"
/// (both). Node sets: "wall" (outer cylinder), "ends" (lowest and highest level).
/// Printed as -0.05 cm in Table II, the minor axis of S27 is taken as +0.05 cm; the length is that of the
/// table, 4 cm, not the 2 cm of the text. The default is the preset coarse.
struct Larynx {
  struct Section {
    double z;      // m
    double minor;  // m, half-axis |x|, > 0 and < radius
  };
  /// Along what the thickness of the layers is measured: level with the ground, or across the surface in the plane
  /// y = 0, where layers of straight pieces are parallel to them (mitred).
  enum class LayersAlong : std::int8_t { level, normal };

  struct Shape {
    /// Table II: S0 S7 S8 S12 S17 S18 S26 S27 S36 S43 S51; straight in between.
    std::vector<Section> sections = thesis_sections();
    double major = 0.7e-2;             // m, half-axis y of every section, > 0 and < radius
    double radius = 0.8e-2;            // m, embedding cylinder
    double layer_thickness = 0.05e-2;  // m, > 0, of cover and of ligament; at most 0.3 of the tissue's depth each
    std::optional<double> ligament_thickness;  // m, > 0; absent: that of the cover
    int layers_from_section = 4;               // S17: cover and ligament lie between these two sections
    int layers_to_section = 7;                 // S27
    LayersAlong layers_along = LayersAlong::level;
    void validate() const;
  };

  /// Structured: levels at the heights of sections, rings from airway to wall. The way of the thesis; cells are
  /// flat where a nearly level surface meets the levels, and sides are straight.
  struct Levels {
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
  };

  /// The half section y = 0 triangulated with the layers as lines of it and carried around the airway, prisms cut
  /// into tetrahedra, one quadrant smoothed and mirrored; sides of quadratic cells are curved.
  struct Triangulated {
    double size = 0.35e-3;  // m, > 0: edges between the sections that the layers lie between
    double growth = 0.7;    // >= 0: edges are longer by this times the distance from there
    /// Mesh lines around the airway, a multiple of 4, >= 8; at (x, y) = (minor cos t, major sin t) on the ellipse
    /// and at the angle t on the cylinder, t even.
    int around = 12;
    /// >= 0: quads between the last two lines are cut from the tip where the airway's line before it is less than
    /// this times its distance from the tip off the middle plane. Cut from that line they would be flat there, and
    /// first to turn inside out.
    double tip_cut = 0.1;
  };

  Shape shape;
  std::variant<Triangulated, Levels> meshed = Triangulated{};
  void validate() const;
  /// The same larynx with edges shorter by `factor` > 0: levels, lines and rings times it, to the nearest (lines:
  /// the nearest multiple of 4), sizes and their growth divided by it.
  Larynx refined(double factor) const;

  static std::vector<Section> thesis_sections();
  /// By purpose. Quadratic, the wall held: unknowns, and by how much the lowest three symmetric frequencies are
  /// high (docs/verification/tissue.md).
  static Larynx coarse();  // 9864; 2.1, 1.6, 2.1 %: tests and first tries
  static Larynx demo();    // 21720; 0.6, 0.4, 0.5 %
  static Larynx fine();    // 43440; 0.3, 0.2, 0.2 %
  static Larynx finest();  // 87984; 0.1, 0.0, 0.0 %
  /// In levels. 52 of them as in the thesis, at its 52 sections except in the first and last interval, where they
  /// are graded: 55080 tetrahedra (54984 in Paper A, Sec. 3), 11232 nodes.
  static Larynx thesis();
  static Larynx thesis_coarse();  // 4032 tetrahedra, 900 nodes
  static Larynx thesis_demo();    // 7296 tetrahedra, 1600 nodes
  static Larynx thesis_medium();  // 19440 tetrahedra, 4032 nodes
};

/// Linear tetrahedra; throws InvalidInput where the options are out of range or a cell would be turned inside out.
TetMesh larynx_mesh(const Larynx& larynx);

/// Quadratic ones. Triangulated: mid-side nodes of the airway lie on the ellipse of their height, of the wall on
/// the cylinder, inside they follow both by depth, and less where det dx/dxi would fall below a tenth of the
/// straight cell's. In levels: sides are straight.
TetMesh quadratic_larynx_mesh(const Larynx& larynx);

}  // namespace plica

#pragma once
#include <vector>

#include "plica/airflow/sections.hpp"
#include "plica/core/require.hpp"

namespace plica {

/// Sections at the mesh's levels as half-ellipses with their own minor half-axes, Paper A, Eq. (3).
struct EllipticSections {};
/// Sections cut from the interface at rest and carried by the tissue, dense where the glottis is narrow.
struct CutSections {
  int sections = 200;  // in [2, 1000], whatever the mesh's levels
};

/// Areas of all sections from the widths of the airway at stations along y. A width is a fixed combination of the
/// x of few surface nodes: linear in the displacement, and of a displacement it is the change of width.
class SectionAreas {
 public:
  /// One station a section, in the mid-coronal plane: two half-ellipses with their own minor half-axes, Paper A,
  /// Eq. (3); negative where the folds overlap.
  static SectionAreas elliptic(const Sections& sections);
  /// 32 stations a section, where lines along x cut the surface at rest (curved six-node faces as 64 facets each);
  /// they are carried by the tissue. Area = sum of widths, those of overlap counting zero, times the spacing of
  /// the stations at y = middle + major cos(theta), even in theta: exact for a slit, 0.04 % too little for an
  /// ellipse. Sets major and middle of the sections to the surface's. Throws InvalidInput where the air is not
  /// bounded on both sides.
  static SectionAreas cut(const TetMesh& mesh, const Faces& surface, Sections& sections);

  /// (s * stations) m, section by section, at positions x (n, 3), or of displacements. O(s * stations).
  Vector widths(const Points& x) const;
  /// (s) m^2 of these widths: continuous, and linear as long as no width changes its sign.
  Vector areas(const Vector& widths) const;

  /// The part of a node's x in a width.
  struct Term {
    std::int32_t node;
    double weight;
  };
  /// Rows of widths(), as many a section.
  std::ptrdiff_t width_count() const { return static_cast<std::ptrdiff_t>(spacing_.size()); }
  std::ptrdiff_t section_of(std::ptrdiff_t width) const {
    require_index("SectionAreas", "width", width, width_count());
    return width / (width_count() / sections_);
  }
  /// What a width is the sum of.
  std::vector<Term> terms(std::ptrdiff_t width) const {
    require_index("SectionAreas", "width", width, width_count());
    const auto row = static_cast<std::size_t>(width);
    return {terms_.begin() + static_cast<std::ptrdiff_t>(row_start_[row]),
            terms_.begin() + static_cast<std::ptrdiff_t>(row_start_[row + 1])};
  }
  double spacing(std::ptrdiff_t width) const {  // m
    require_index("SectionAreas", "width", width, width_count());
    return spacing_[static_cast<std::size_t>(width)];
  }
  /// Whether widths of overlap count zero, so that areas are linear in widths only where none is negative.
  bool clipped() const { return clipped_; }

 private:
  void add_row(const std::vector<Term>& terms, double spacing);

  bool clipped_ = false;
  std::ptrdiff_t sections_ = 0;
  std::ptrdiff_t nodes_ = 0;  // of which x is read: one more than the last of them
  std::vector<std::size_t> row_start_{0};
  std::vector<Term> terms_;
  std::vector<double> spacing_;  // (s * stations) m, what a width counts for
};

}  // namespace plica

#pragma once
#include "plica/airflow/section_areas.hpp"
#include "plica/dynamics/distant_values.hpp"
#include "plica/mesh/mirror.hpp"

namespace plica {

/// What overlap takes from section areas that are linear in the coordinates of a motion: a negative width counts
/// zero (SectionAreas::areas). Widths between the same nodes are a group, computed only where the coordinates have
/// gone far enough since it was last for one of them to be negative: exact, and the same whatever was before.
class OverlappingWidths {
 public:
  /// Nodes are at `reference` (n, 3) m and move by shapes (unknowns, r); images: of a symmetric motion, else null.
  OverlappingWidths(const SectionAreas& areas, const MirrorImages* images, const Points& reference,
                    const Eigen::MatrixXd& shapes);

  /// Adds to areas (s) m^2, linear in coordinates q (r), what widths < 0 there have taken from them.
  void add(const Vector& q, Vector& areas);

 private:
  struct Group {
    std::vector<std::int32_t> nodes;     // places in x_
    std::vector<std::int32_t> sections;  // (widths)
    Vector spacing;                      // (widths) m
    PanelMatrix weights;                 // (widths, nodes)
    double speed = 0.0;                  // a width changes by at most so many times what coordinates do
    double least = 0.0;                  // m, of its widths when last computed
    double seen_at = -1.0;               // path until then; < 0: never
  };
  void compute(Group& group, Vector& areas);

  DistantValues x_;  // m, of nodes
  std::vector<Group> groups_;
  Vector at_;  // m, x of a group's nodes
};

}  // namespace plica

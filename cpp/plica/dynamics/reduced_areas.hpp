#pragma once
#include "plica/airflow/section_areas.hpp"
#include "plica/dynamics/mediolateral.hpp"

namespace plica {

/// SectionAreas from mediolateral positions: sums that are linear in them, less what widths < 0, which count zero,
/// take from these. Widths between the same nodes are a group, computed only where the nodes have moved far enough
/// since it was last for one of them to be negative: exact, and the same whatever was before.
class ReducedAreas {
 public:
  /// The positions must have those of all nodes that widths depend on.
  ReducedAreas(const SectionAreas& areas, const Mediolateral& positions);

  /// (s) m^2 at mediolateral positions x (n) m.
  Vector at(const Vector& x);

 private:
  struct Group {
    std::vector<std::int32_t> places;    // in x
    std::vector<std::int32_t> sections;  // (widths)
    Vector spacing;                      // (widths) m
    PanelMatrix weights;                 // (widths, places)
    double speed = 0.0;                  // a width changes by at most so many times what an x does
    double least = 0.0;                  // m, of its widths when last computed
    double seen_at = -1.0;               // path until then; < 0: never
  };
  static Group group(const SectionAreas& areas, std::vector<std::int32_t> places,
                     const std::vector<std::pair<std::ptrdiff_t, std::vector<double>>>& widths);
  void take_overlap(Group& group, const Vector& x, Vector& areas);

  SparsePanels lengths_;  // (s, n) m
  std::vector<Group> groups_;
  Vector x_;           // m, last given
  double path_ = 0.0;  // m, that the farthest x has gone at most
  Vector of_group_;    // m, x of a group's nodes
};

}  // namespace plica

#pragma once
#include "plica/airflow/section_areas.hpp"
#include "plica/mesh/mirror.hpp"

namespace plica {

/// What overlap takes from section areas that are linear in the motion: a negative width counts zero
/// (SectionAreas::areas). Widths between the same nodes are a group, which is looked at only where its nodes have
/// moved, since it was last, by as much as its least width allows: exact, and the same whatever was looked at
/// before.
class OverlappingWidths {
 public:
  /// images: of a symmetric motion, else null. Empty where no width counts zero.
  OverlappingWidths(const SectionAreas& areas, const MirrorImages* images);

  /// Whose x it reads, ascending; of a symmetric motion those of its part.
  const Indices& nodes() const { return nodes_; }
  /// Adds to areas (s) m^2 what widths < 0 have taken from them. x (nodes) m.
  void add(Eigen::Ref<const Vector> x, Vector& areas);

 private:
  struct Width {
    std::int32_t section;
    double spacing;                // m
    std::ptrdiff_t first_weight;   // its group's count of them
  };
  struct Group {
    std::ptrdiff_t first_node, node_count;    // in group_nodes_ and seen_
    std::ptrdiff_t first_width, width_count;  // in widths_
    double growth;  // -, a width changes by at most so many times the largest change of a node's x
    double least;   // m, of its widths when last looked at
  };
  void look(Group& group, const double* x, Vector& areas);

  Indices nodes_;
  std::vector<Group> groups_;
  std::vector<Width> widths_;
  std::vector<double> weights_;
  std::vector<std::int32_t> group_nodes_;  // places in nodes_
  std::vector<double> seen_;               // m, x of these when last looked at
};

}  // namespace plica

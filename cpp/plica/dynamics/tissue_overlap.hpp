#pragma once
#include <array>
#include <optional>
#include <vector>

#include "plica/contact/pairs.hpp"
#include "plica/core/types.hpp"

namespace plica {

/// One of `nodes` that at positions x (n, 3) lies in a cell that it is no node of, further from the tissue's
/// boundary than the fraction `deep` of the cell's height there; corners of the cells only. A brute-force test,
/// for once: O(cells log cells + cells x nodes in their range of x).
std::optional<std::int32_t> node_in_tissue(const Points& x, const Cells& cells, const Indices& nodes, double deep);

/// Holds a contact against the tissue itself, whatever its airway and its gaps say: which nodes of one surface lie
/// in cells behind the other.
class TissueOverlap {
 public:
  /// Cells (m, 4 or 10; quadratic ones as eight linear ones) lie behind the surface that is fewer cells away.
  /// `reference`, (n, 3) m: positions at rest, where nothing overlaps. Linear ones that are turned inside out
  /// there, as of strongly curved cells, or hold a node of the other surface in them, tell nothing and are left
  /// out.
  TissueOverlap(const Cells& cells, const Detector& detector, const Points& reference);

  /// How deep (m, >= 0) a node lies in the tissue behind the other surface, at most: to the closest point of that.
  /// x (n, 3): the positions of the detector's last update. O(nodes), where both come near each other
  /// O(cells).
  double depth(const Points& x, const Detector& detector) const;

 private:
  /// Cells that lie beside each other at rest: a box around their nodes spares the look at each.
  struct Group {
    std::ptrdiff_t first, last;  // of behind_: from the first to before the last
    std::vector<std::int32_t> nodes;
  };

  /// Orders the cells from `first` to before `last` by groups, halving them across their longest axis.
  static void gather(const Points& centres, std::vector<std::ptrdiff_t>& cells, std::ptrdiff_t first,
                     std::ptrdiff_t last, std::vector<Group>& groups);
  /// Calls visit(cell of behind_[1 - side], node) for each node of that side's surface in it, by more than `least`
  /// of its height over each face.
  template <class Visit>
  void each_inside(int side, const Points& x, const Detector& detector, double least, Visit visit) const;

  std::array<Cells, 2> behind_;               // (m, 4), the first and the second surface; group after group
  std::array<std::vector<Group>, 2> groups_;  // of these
};

}  // namespace plica

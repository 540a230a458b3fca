#pragma once
#include <Eigen/Geometry>
#include <vector>

#include "plica/core/types.hpp"

namespace plica {

/// A binary tree of boxes around triangles, by which those near a point are found without looking at all. Which
/// triangles share a box is settled once, where they lie at first; their boxes follow them.
class TriangleTree {
 public:
  /// Of triangles (f, 3) at positions x those `among`, numbers. O(n log n) of these.
  TriangleTree(const Triangles& triangles, std::vector<std::int32_t> among, const Points& x);

  /// Takes up positions x of the same triangles. O(n).
  void update(const Triangles& triangles, const Points& x);

  /// Calls visit(triangle) -> m^2, the square of a bound that may fall from call to call, for each triangle whose
  /// box is no further from p than the bound: nearest boxes first, O(log f) of them where the bound falls to the
  /// distance.
  template <class Visit>
  void near(const Vector3& p, double squared_bound, Visit visit) const {
    descend(0, p, squared_bound, visit);
  }

 private:
  /// Of a node of the tree. Children of node i: i + 1 and `second`; a leaf has none (0) and its triangles.
  struct Branch {
    Eigen::AlignedBox3d box;
    std::int32_t second = 0, begin = 0, end = 0;  // begin, end: places in order_
  };

  void build(const Points& centres, std::int32_t begin, std::int32_t end);

  template <class Visit>
  void descend(std::int32_t at, const Vector3& p, double& squared_bound, Visit& visit) const {
    const Branch& branch = branches_[static_cast<std::size_t>(at)];
    if (branch.second == 0) {
      for (std::int32_t i = branch.begin; i < branch.end; ++i)
        squared_bound = visit(order_[static_cast<std::size_t>(i)]);
      return;
    }
    std::int32_t nearer = at + 1, further = branch.second;
    double to_nearer = distance(nearer, p), to_further = distance(further, p);
    if (to_further < to_nearer) std::swap(nearer, further), std::swap(to_nearer, to_further);
    if (to_nearer <= squared_bound) descend(nearer, p, squared_bound, visit);
    if (to_further <= squared_bound) descend(further, p, squared_bound, visit);
  }
  double distance(std::int32_t at, const Vector3& p) const {
    return branches_[static_cast<std::size_t>(at)].box.squaredExteriorDistance(p);
  }

  std::vector<Branch> branches_;     // parents before their children
  std::vector<std::int32_t> order_;  // triangles, those of a leaf together
};

}  // namespace plica

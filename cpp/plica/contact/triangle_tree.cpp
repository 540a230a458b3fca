#include "plica/contact/triangle_tree.hpp"

#include <algorithm>

namespace plica {

TriangleTree::TriangleTree(const Triangles& triangles, std::vector<std::int32_t> among, const Points& x)
    : order_(std::move(among)) {
  Points centres(triangles.rows(), 3);
  for (const std::int32_t t : order_)
    centres.row(t) = (x.row(triangles(t, 0)) + x.row(triangles(t, 1)) + x.row(triangles(t, 2))) / 3.0;
  branches_.reserve(order_.size());
  build(centres, 0, static_cast<std::int32_t>(order_.size()));
  update(triangles, x);
}

/// Halves of equal number, split across the longest side of their centres' box.
void TriangleTree::build(const Points& centres, std::int32_t begin, std::int32_t end) {
  constexpr std::int32_t of_a_leaf = 4;  // triangles, at most
  const std::size_t at = branches_.size();
  branches_.emplace_back();
  branches_[at].begin = begin;
  branches_[at].end = end;
  if (end - begin <= of_a_leaf) return;
  Eigen::AlignedBox3d box;
  for (std::int32_t i = begin; i < end; ++i) box.extend(Vector3(centres.row(order_[i])));
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const std::int32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::int32_t a, std::int32_t b) {
                     return centres(a, axis) < centres(b, axis) || (centres(a, axis) == centres(b, axis) && a < b);
                   });
  build(centres, begin, middle);
  branches_[at].second = static_cast<std::int32_t>(branches_.size());
  build(centres, middle, end);
}

void TriangleTree::update(const Triangles& triangles, const Points& x) {
  for (std::size_t at = branches_.size(); at-- > 0;) {
    Branch& branch = branches_[at];
    branch.box.setEmpty();
    if (branch.second > 0) {
      branch.box.extend(branches_[at + 1].box).extend(branches_[static_cast<std::size_t>(branch.second)].box);
      continue;
    }
    for (std::int32_t i = branch.begin; i < branch.end; ++i)
      for (const std::int32_t node : triangles.row(order_[i])) branch.box.extend(Vector3(x.row(node)));
  }
}

}  // namespace plica

#include "plica/dynamics/overlapping_widths.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace plica {

OverlappingWidths::OverlappingWidths(const SectionAreas& areas, const MirrorImages* images) {
  if (!areas.clipped()) return;
  struct Row {
    std::ptrdiff_t width;
    std::vector<double> weights;
  };
  std::map<std::vector<std::int32_t>, std::vector<Row>> groups;  // by their nodes
  std::vector<std::int32_t> all;
  for (std::ptrdiff_t width = 0; width < areas.width_count(); ++width) {
    std::map<std::int32_t, double> sums;
    for (const auto& [node, weight] : areas.terms(width)) {
      const std::int32_t own = images ? images->nodes()[images->node_of(node)] : node;
      sums[own] += images ? images->sign(node)[0] * weight : weight;
    }
    std::vector<std::int32_t> nodes;
    Row row{width, {}};
    for (const auto& [node, weight] : sums) {
      nodes.push_back(node);
      row.weights.push_back(weight);
    }
    all.insert(all.end(), nodes.begin(), nodes.end());
    groups[std::move(nodes)].push_back(std::move(row));
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  nodes_ = Eigen::Map<Indices>(all.data(), static_cast<std::ptrdiff_t>(all.size()));
  for (const auto& [nodes, rows] : groups) {
    Group group{static_cast<std::ptrdiff_t>(group_nodes_.size()), static_cast<std::ptrdiff_t>(nodes.size()),
                static_cast<std::ptrdiff_t>(widths_.size()), static_cast<std::ptrdiff_t>(rows.size()), 0.0,
                -1.0};  // < 0: not looked at yet
    for (const std::int32_t node : nodes)
      group_nodes_.push_back(
          static_cast<std::int32_t>(std::lower_bound(all.begin(), all.end(), node) - all.begin()));
    for (const Row& row : rows) {
      widths_.push_back({static_cast<std::int32_t>(areas.section_of(row.width)), areas.spacing(row.width),
                         static_cast<std::ptrdiff_t>(weights_.size())});
      weights_.insert(weights_.end(), row.weights.begin(), row.weights.end());
      double sum = 0;
      for (const double weight : row.weights) sum += std::abs(weight);
      group.growth = std::max(group.growth, sum);
    }
    groups_.push_back(group);
  }
  seen_.assign(group_nodes_.size(), 0.0);
}

void OverlappingWidths::add(Eigen::Ref<const Vector> x, Vector& areas) {
  constexpr double round_off = 1e-14;  // m: what a width computed from nodes within a decimetre can be off by
  for (Group& group : groups_) {
    double moved = 0;
    for (std::ptrdiff_t k = group.first_node; k < group.first_node + group.node_count; ++k)
      moved = std::max(moved, std::abs(x[group_nodes_[static_cast<std::size_t>(k)]] -
                                       seen_[static_cast<std::size_t>(k)]));
    if (!(group.least - group.growth * moved > round_off)) look(group, x.data(), areas);
  }
}

void OverlappingWidths::look(Group& group, const double* x, Vector& areas) {
  double* seen = seen_.data() + group.first_node;
  for (std::ptrdiff_t k = 0; k < group.node_count; ++k)
    seen[k] = x[group_nodes_[static_cast<std::size_t>(group.first_node + k)]];
  group.least = std::numeric_limits<double>::infinity();
  for (std::ptrdiff_t w = group.first_width; w < group.first_width + group.width_count; ++w) {
    const Width& width = widths_[static_cast<std::size_t>(w)];
    const double* weight = weights_.data() + width.first_weight;
    double sum = 0;
    for (std::ptrdiff_t k = 0; k < group.node_count; ++k) sum += weight[k] * seen[k];
    group.least = std::min(group.least, sum);
    if (!(sum >= 0)) areas[width.section] -= width.spacing * sum;
  }
}

}  // namespace plica

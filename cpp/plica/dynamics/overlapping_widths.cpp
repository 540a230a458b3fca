#include "plica/dynamics/overlapping_widths.hpp"

#include <algorithm>
#include <limits>
#include <map>

namespace plica {

OverlappingWidths::OverlappingWidths(const SectionAreas& areas, const MirrorImages* images,
                                     const Points& reference, const Eigen::MatrixXd& shapes) {
  if (!areas.clipped()) return;
  struct Row {
    std::ptrdiff_t width;
    std::vector<double> weights;
  };
  // By their nodes, of a symmetric motion those of the part: an image has its x, or minus that.
  std::map<std::vector<std::int32_t>, std::vector<Row>> groups;
  std::vector<std::int32_t> all;
  for (std::ptrdiff_t width = 0; width < areas.width_count(); ++width) {
    std::map<std::int32_t, double> sums;
    for (const auto& [node, weight] : areas.terms(width))
      sums[images ? images->node_of(node) : node] += images ? images->sign(node)[0] * weight : weight;
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
  const auto count = static_cast<std::ptrdiff_t>(all.size());
  Vector rest(count);
  Eigen::MatrixXd rows(count, shapes.cols());
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const std::int32_t node = all[static_cast<std::size_t>(i)];
    rest[i] = reference(images ? images->nodes()[node] : node, 0);
    rows.row(i) = shapes.row(3 * static_cast<std::ptrdiff_t>(node));
  }
  std::size_t most_nodes = 0;
  for (const auto& [nodes, members] : groups) {
    Group group{static_cast<std::ptrdiff_t>(group_nodes_.size()), static_cast<std::ptrdiff_t>(nodes.size()),
                static_cast<std::ptrdiff_t>(widths_.size()), static_cast<std::ptrdiff_t>(members.size())};
    most_nodes = std::max(most_nodes, nodes.size());
    for (const std::int32_t node : nodes)
      group_nodes_.push_back(
          static_cast<std::int32_t>(std::lower_bound(all.begin(), all.end(), node) - all.begin()));
    for (const Row& member : members) {
      widths_.push_back({static_cast<std::int32_t>(areas.section_of(member.width)), areas.spacing(member.width),
                         static_cast<std::ptrdiff_t>(weights_.size())});
      weights_.insert(weights_.end(), member.weights.begin(), member.weights.end());
      Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(shapes.cols());
      for (std::size_t k = 0; k < nodes.size(); ++k)
        row += member.weights[k] * rows.row(group_nodes_[static_cast<std::size_t>(group.first_node) + k]);
      group.speed = std::max(group.speed, row.norm());
    }
    groups_.push_back(group);
  }
  at_.resize(most_nodes);
  x_ = DistantValues(std::move(rest), rows);
}

void OverlappingWidths::add(const Vector& q, Vector& areas) {
  constexpr double round_off = 1e-14;  // m: by which a width between nodes within a decimetre can be off
  if (groups_.empty()) return;
  x_.move(q);
  for (Group& group : groups_)
    if (!(group.seen_at >= 0 && group.least - group.speed * (x_.path() - group.seen_at) > round_off))
      compute(group, areas);
}

void OverlappingWidths::compute(Group& group, Vector& areas) {
  const std::int32_t* nodes = group_nodes_.data() + group.first_node;
  for (std::ptrdiff_t k = 0; k < group.node_count; ++k) at_[static_cast<std::size_t>(k)] = x_.value(nodes[k]);
  group.least = std::numeric_limits<double>::infinity();
  group.seen_at = x_.path();
  for (std::ptrdiff_t w = group.first_width; w < group.first_width + group.width_count; ++w) {
    const Width& width = widths_[static_cast<std::size_t>(w)];
    const double* weight = weights_.data() + width.first_weight;
    double sum = 0;
    for (std::ptrdiff_t k = 0; k < group.node_count; ++k) sum += weight[k] * at_[static_cast<std::size_t>(k)];
    group.least = std::min(group.least, sum);
    if (!(sum >= 0)) areas[width.section] -= width.spacing * sum;
  }
}

}  // namespace plica

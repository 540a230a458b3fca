#include "plica/dynamics/overlapping_widths.hpp"

#include <algorithm>
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
  for (const auto& [nodes, members] : groups) {
    Group group;
    for (const std::int32_t node : nodes)
      group.nodes.push_back(
          static_cast<std::int32_t>(std::lower_bound(all.begin(), all.end(), node) - all.begin()));
    const auto widths = static_cast<std::ptrdiff_t>(members.size());
    group.spacing.resize(widths);
    Eigen::MatrixXd weights(widths, static_cast<std::ptrdiff_t>(nodes.size()));
    for (std::ptrdiff_t w = 0; w < widths; ++w) {
      const Row& member = members[static_cast<std::size_t>(w)];
      group.sections.push_back(static_cast<std::int32_t>(areas.section_of(member.width)));
      group.spacing[w] = areas.spacing(member.width);
      weights.row(w) = Eigen::Map<const Eigen::RowVectorXd>(member.weights.data(), weights.cols());
    }
    group.speed = (weights * rows(group.nodes, Eigen::all)).rowwise().norm().maxCoeff();
    group.weights = PanelMatrix(weights);
    groups_.push_back(std::move(group));
  }
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
  at_.resize(group.weights.cols());
  for (std::ptrdiff_t k = 0; k < at_.size(); ++k) at_[k] = x_.value(group.nodes[static_cast<std::size_t>(k)]);
  const Vector width = group.weights * at_;
  group.least = width.minCoeff();
  group.seen_at = x_.path();
  if (group.least >= 0) return;
  for (std::ptrdiff_t w = 0; w < width.size(); ++w)
    if (!(width[w] >= 0)) areas[group.sections[static_cast<std::size_t>(w)]] -= group.spacing[w] * width[w];
}

}  // namespace plica

#include "plica/dynamics/reduced_areas.hpp"

#include <algorithm>
#include <map>

namespace plica {

ReducedAreas::ReducedAreas(const SectionAreas& areas, const Mediolateral& positions) : x_(positions.rest()) {
  std::map<std::vector<std::int32_t>, std::vector<std::pair<std::ptrdiff_t, std::vector<double>>>> groups;
  std::vector<SparsePanels::Entry> lengths;
  std::int32_t sections = 0;
  for (std::ptrdiff_t width = 0; width < areas.width_count(); ++width) {
    const auto section = static_cast<std::int32_t>(areas.section_of(width));
    sections = std::max(sections, section + 1);
    std::map<std::int32_t, double> sums;
    for (const auto& [node, weight] : areas.terms(width))
      sums[positions.place(node)] += positions.sign(node) * weight;
    std::vector<std::int32_t> places;
    std::vector<double> weights;
    for (const auto& [place, weight] : sums) {
      lengths.push_back({section, place, areas.spacing(width) * weight});
      places.push_back(place);
      weights.push_back(weight);
    }
    if (areas.clipped()) groups[std::move(places)].emplace_back(width, std::move(weights));
  }
  lengths_ = SparsePanels(sections, lengths);
  for (const auto& [places, widths] : groups) groups_.push_back(group(areas, places, widths));
}

ReducedAreas::Group ReducedAreas::group(
    const SectionAreas& areas, std::vector<std::int32_t> places,
    const std::vector<std::pair<std::ptrdiff_t, std::vector<double>>>& widths) {
  Group group;
  group.places = std::move(places);
  Eigen::MatrixXd weights(static_cast<std::ptrdiff_t>(widths.size()),
                          static_cast<std::ptrdiff_t>(group.places.size()));
  group.spacing.resize(weights.rows());
  for (std::ptrdiff_t w = 0; w < weights.rows(); ++w) {
    const auto& [width, row] = widths[static_cast<std::size_t>(w)];
    weights.row(w) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), weights.cols());
    group.sections.push_back(static_cast<std::int32_t>(areas.section_of(width)));
    group.spacing[w] = areas.spacing(width);
  }
  group.speed = (1 + 1e-9) * weights.rowwise().lpNorm<1>().maxCoeff();
  group.weights = PanelMatrix(weights);
  return group;
}

Vector ReducedAreas::at(const Vector& x) {
  constexpr double round_off = 1e-14;  // m: by which a width between nodes within a decimetre can be off
  Vector areas = lengths_ * x;
  if (groups_.empty()) return areas;
  path_ += (x - x_).lpNorm<Eigen::Infinity>();
  x_ = x;
  for (Group& group : groups_)
    if (!(group.seen_at >= 0 && group.least - group.speed * (path_ - group.seen_at) > round_off))
      take_overlap(group, x, areas);
  return areas;
}

void ReducedAreas::take_overlap(Group& group, const Vector& x, Vector& areas) {
  of_group_.resize(group.weights.cols());
  for (std::ptrdiff_t k = 0; k < of_group_.size(); ++k)
    of_group_[k] = x[group.places[static_cast<std::size_t>(k)]];
  const Vector widths = group.weights * of_group_;
  group.least = widths.minCoeff();
  group.seen_at = path_;
  if (group.least >= 0) return;
  for (std::ptrdiff_t w = 0; w < widths.size(); ++w)
    if (!(widths[w] >= 0)) areas[group.sections[static_cast<std::size_t>(w)]] -= group.spacing[w] * widths[w];
}

}  // namespace plica

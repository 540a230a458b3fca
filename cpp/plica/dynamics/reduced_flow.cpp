#include "plica/dynamics/reduced_flow.hpp"

#include <algorithm>

#include "plica/core/error.hpp"

namespace plica {

namespace {

/// Area of each section (s, r) that shapes add where no width is negative, from the x (n, r) that they add.
Eigen::MatrixXd linear_areas(const SectionAreas& areas, std::ptrdiff_t sections, const ModalMotion& motion,
                             const Indices& nodes) {
  std::vector<std::int32_t> place(static_cast<std::size_t>(nodes.maxCoeff()) + 1, -1);
  for (std::int32_t i = 0; i < nodes.size(); ++i) place[static_cast<std::size_t>(nodes[i])] = i;
  const Eigen::MatrixXd shapes = motion.shapes_at(nodes)(Eigen::seqN(0, nodes.size(), 3), Eigen::all);
  Eigen::MatrixXd of_nodes = Eigen::MatrixXd::Zero(sections, nodes.size());  // m, of 1 m of a node's x
  for (std::ptrdiff_t width = 0; width < areas.width_count(); ++width)
    for (const auto& [node, weight] : areas.terms(width))
      of_nodes(areas.section_of(width), place[static_cast<std::size_t>(node)]) += areas.spacing(width) * weight;
  return of_nodes * shapes;
}

}  // namespace

ReducedFlow::ReducedFlow(const Airflow& airflow, const Motion& full, const ModalMotion& motion)
    : airflow_(airflow),
      overlap_(airflow.section_areas(), full.images(), full.reference(), motion.shapes()),
      right_(line(airflow.sections().right, full, motion)),
      left_(line(airflow.sections().left, full, motion)) {
  if (!std::holds_alternative<Airflow::ReferenceShape>(airflow.options().load_shape))
    throw InvalidInput(
        "Reduction: airflow.load_shape = \"current\"; must be \"reference\", whose load is linear in the "
        "pressures.");
  const SectionAreas& areas = airflow.section_areas();
  const std::ptrdiff_t sections = airflow.sections().count();
  Vector overlapping = Vector::Zero(sections);
  overlap_.add(Vector::Zero(motion.size()), overlapping);
  areas_ = areas.areas(areas.widths(full.reference())) - overlapping;
  area_shapes_ = PanelMatrix(linear_areas(areas, sections, motion, airflow.nodes()));

  const LoadPatterns& patterns = airflow.load_patterns();
  const Eigen::MatrixXd shapes = motion.shapes_at(airflow.nodes());
  below_ = airflow.options().subglottal_pressure * (shapes.transpose() * patterns.subglottal);
  sections_ = PanelMatrix((patterns.sections.transpose() * shapes).transpose());
}

Vector ReducedFlow::areas(const Vector& q) {
  Vector areas = areas_ + area_shapes_ * q;
  overlap_.add(q, areas);
  return areas;
}

ReducedFlow::Line ReducedFlow::line(const std::vector<MaterialPoint>& points, const Motion& full,
                                    const ModalMotion& motion) {
  std::vector<std::int32_t> nodes;
  for (const MaterialPoint& point : points) nodes.insert(nodes.end(), point.nodes.begin(), point.nodes.end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  const Points reference = full.in_scene(full.reference());
  Line line;
  line.rest.resize(static_cast<std::ptrdiff_t>(points.size()), 3);
  line.shapes =
      PanelMatrix(motion.shapes_at(Eigen::Map<Indices>(nodes.data(), static_cast<std::ptrdiff_t>(nodes.size()))));
  for (std::size_t s = 0; s < points.size(); ++s) {
    line.rest.row(static_cast<std::ptrdiff_t>(s)) = points[s].at(reference);
    for (std::size_t k = 0; k < points[s].nodes.size(); ++k) {
      const auto at = std::lower_bound(nodes.begin(), nodes.end(), points[s].nodes[k]) - nodes.begin();
      line.terms.push_back({static_cast<std::int32_t>(s), static_cast<std::int32_t>(at), points[s].weights[k]});
    }
  }
  return line;
}

Points ReducedFlow::coronal(Side side, const Vector& q) const {
  const Line& line = side == Side::right ? right_ : left_;
  const Vector moved = line.shapes * q;
  Points at = line.rest;
  for (const auto& [point, node, weight] : line.terms)
    at.row(point) += weight * moved.segment<3>(3 * static_cast<std::ptrdiff_t>(node)).transpose();
  return at;
}

}  // namespace plica

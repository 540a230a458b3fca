#include "plica/dynamics/reduced_flow.hpp"

#include <map>

#include "plica/core/error.hpp"

namespace plica {

ReducedFlow::ReducedFlow(const Airflow& airflow, const Motion& full, const ModalMotion& motion,
                         const Mediolateral& positions, bool ends)
    : airflow_(airflow),
      areas_(airflow.section_areas(), positions),
      ends_(ends),
      right_(line(airflow.sections().right, full, motion)) {
  if (!full.images()) left_ = line(airflow.sections().left, full, motion);
  if (!std::holds_alternative<Airflow::ReferenceShape>(airflow.options().load_shape))
    throw InvalidInput(
        "Reduction: airflow.load_shape = \"current\"; must be \"reference\", whose load is linear in the "
        "pressures.");
  const LoadPatterns& patterns = airflow.load_patterns();
  const Eigen::MatrixXd shapes = motion.shapes_at(airflow.nodes());
  below_ = shapes.transpose() * patterns.below;
  above_ = shapes.transpose() * patterns.above;
  const Eigen::MatrixXd sections = (patterns.sections.transpose() * shapes).transpose();
  Eigen::MatrixXd accelerations = motion.inverse() * sections;
  if (ends) {
    const std::ptrdiff_t count = sections.cols();
    accelerations.conservativeResize(Eigen::NoChange, count + 2);
    accelerations.col(count) = motion.inverse() * below_;
    accelerations.col(count + 1) = motion.inverse() * above_;
  }
  sections_ = PanelMatrix(sections);
  rates_ = PanelMatrix(sections.transpose());
  Eigen::MatrixXd borders(sections.cols() + 2, sections.rows());
  borders << sections.transpose(), below_.transpose(), above_.transpose();
  expansions_ = PanelMatrix(borders * accelerations);
  accelerations_ = PanelMatrix(accelerations);
  x_accelerations_ = SinglePanelMatrix(positions.shapes() * accelerations);
}

Vector ReducedFlow::moving(const AirwayPressure& pressure, const AirwayPressure& begun) const {
  if (!ends_) {
    if (!pressure.same_ends(begun))
      throw InvalidInput(
          "ReducedFlow: the pressure at the ends has changed within a step; must be made with ends.");
    return pressure.sections;
  }
  Vector all = pressure.all();
  all[all.size() - 2] -= begun.below;
  all[all.size() - 1] -= begun.above;
  return all;
}

std::array<AirwayExpansion, 2> ReducedFlow::expansions(const TwoColumns& velocities) const {
  const TwoColumns sections = rates_ * velocities;
  std::array<AirwayExpansion, 2> found;
  for (int v = 0; v < 2; ++v)
    found[static_cast<std::size_t>(v)] = {below_.dot(velocities.col(v)), sections.col(v),
                                          above_.dot(velocities.col(v))};
  return found;
}

void ReducedFlow::add_expansion(double factor, const Vector& pressure, AirwayExpansion& found) const {
  const Vector added = factor * (expansions_ * pressure);
  const std::ptrdiff_t count = found.sections.size();
  found.sections += added.head(count);
  found.below += added[count];
  found.above += added[count + 1];
}

ReducedFlow::Line ReducedFlow::line(const std::vector<MaterialPoint>& points, const Motion& full,
                                    const ModalMotion& motion) {
  const Points reference = full.in_scene(full.reference());
  Line line;
  line.rest.resize(static_cast<std::ptrdiff_t>(points.size()), 3);
  std::map<std::int32_t, std::int32_t> first;  // of the components of a node, 3 a node
  std::vector<std::int32_t> nodes;
  for (const MaterialPoint& point : points)
    for (const std::int32_t node : point.nodes)
      if (first.emplace(node, 3 * static_cast<std::int32_t>(nodes.size())).second) nodes.push_back(node);
  const Eigen::MatrixXd shapes =
      motion.shapes_at(Eigen::Map<Indices>(nodes.data(), static_cast<std::ptrdiff_t>(nodes.size())));
  std::vector<std::int32_t> row(static_cast<std::size_t>(shapes.rows()), -1), moving;
  for (std::size_t s = 0; s < points.size(); ++s) {
    line.rest.row(static_cast<std::ptrdiff_t>(s)) = points[s].at(reference);
    for (std::size_t k = 0; k < points[s].nodes.size(); ++k)
      for (std::int32_t axis = 0; axis < 3; ++axis) {
        const std::int32_t component = first[points[s].nodes[k]] + axis;
        if (points[s].weights[k] == 0 || shapes.row(component).isZero(0)) continue;
        std::int32_t& at = row[static_cast<std::size_t>(component)];
        if (at < 0) {
          at = static_cast<std::int32_t>(moving.size());
          moving.push_back(component);
        }
        line.terms.push_back({3 * static_cast<std::int32_t>(s) + axis, at, points[s].weights[k]});
      }
  }
  line.shapes = PanelMatrix(shapes(moving, Eigen::all));
  return line;
}

Points ReducedFlow::coronal(Side side, const Vector& q) const {
  const bool mirrored = side == Side::left && !left_;
  const Line& line = side == Side::left && left_ ? *left_ : right_;
  const Vector moved = line.shapes * q;
  Points at = line.rest;
  for (const auto& [entry, component, weight] : line.terms) at.data()[entry] += weight * moved[component];
  if (mirrored) at.col(0) = -at.col(0);
  return at;
}

}  // namespace plica

#include "plica/dynamics/reduced_flow.hpp"

#include "plica/core/error.hpp"

namespace plica {

namespace {

Points places(const Sections& sections, const Points& x) {
  Points at(2 * sections.count(), 3);
  for (std::ptrdiff_t s = 0; s < sections.count(); ++s) {
    at.row(s) = sections.right[static_cast<std::size_t>(s)].at(x);
    at.row(sections.count() + s) = sections.left[static_cast<std::size_t>(s)].at(x);
  }
  return at;
}

}  // namespace

ReducedFlow::ReducedFlow(const Airflow& airflow, const Points& reference, const ModalMotion& motion)
    : airflow_(airflow) {
  if (!std::holds_alternative<Airflow::ReferenceShape>(airflow.options().load_shape))
    throw InvalidInput(
        "Reduction: airflow.load_shape = \"current\"; must be \"reference\", whose load is linear in the "
        "pressures.");
  const SectionAreas& areas = airflow.section_areas();
  const std::ptrdiff_t r = motion.size();
  widths_ = areas.widths(reference);
  areas_ = areas.areas(widths_);
  coronal_ = places(airflow.sections(), reference);
  width_shapes_.resize(widths_.size(), r);
  area_shapes_.resize(areas_.size(), r);
  coronal_shapes_.resize(coronal_.size(), r);
  for (std::ptrdiff_t j = 0; j < r; ++j) {
    const Vector shape = motion.shapes().col(j);
    const Points moved = as_points(shape);
    width_shapes_.col(j) = areas.widths(moved);
    area_shapes_.col(j) =
        areas.areas(width_shapes_.col(j).cwiseMax(0.0)) - areas.areas((-width_shapes_.col(j)).cwiseMax(0.0));
    coronal_shapes_.col(j) = as_vector(places(airflow.sections(), moved));
  }
  const LoadPatterns& patterns = airflow.load_patterns();
  Eigen::MatrixXd shapes(patterns.subglottal.size(), r);  // of the flow's nodes
  for (std::ptrdiff_t n = 0; n < airflow.nodes().size(); ++n)
    shapes.middleRows<3>(3 * n) =
        motion.shapes().middleRows<3>(3 * static_cast<std::ptrdiff_t>(airflow.nodes()[n]));
  below_ = airflow.options().subglottal_pressure * (shapes.transpose() * patterns.subglottal);
  sections_ = (patterns.sections.transpose() * shapes).transpose();
  response_ = motion.inverse() * sections_;
  width_response_ = width_shapes_ * response_;
  area_response_ = area_shapes_ * response_;
}

Points ReducedFlow::coronal(const Vector& q) const {
  const Vector moved = coronal_shapes_ * q;
  return coronal_ + as_points(moved);
}

}  // namespace plica

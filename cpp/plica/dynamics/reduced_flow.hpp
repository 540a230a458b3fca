#pragma once
#include "plica/airflow/airflow.hpp"
#include "plica/dynamics/modal_motion.hpp"

namespace plica {

/// The airflow of a scene as its coordinates see it: widths of the airway and loads of its sections are linear in
/// them, areas are not.
class ReducedFlow {
 public:
  /// The airflow, of the scene's nodes at `reference` (n, 3) m, and the motion must outlive it. Throws
  /// InvalidInput for a load on the current shape.
  ReducedFlow(const Airflow& airflow, const Points& reference, const ModalMotion& motion);

  const Airflow& airflow() const { return airflow_; }
  /// (s * stations) m at coordinates q.
  Vector widths(const Vector& q) const { return widths_ + width_shapes_ * q; }
  /// What coordinates q add to them.
  Vector widths_of(const Vector& q) const { return width_shapes_ * q; }
  /// The same of response().
  const Eigen::MatrixXd& width_response() const { return width_response_; }  // (s * stations, s)
  Vector areas(const Vector& widths) const { return airflow_.section_areas().areas(widths); }
  /// (s) m^2 at coordinates q where no width is negative: linear.
  Vector open_areas(const Vector& q) const { return areas_ + area_shapes_ * q; }
  /// What an acceleration response() p adds to them.
  const Eigen::MatrixXd& area_response() const { return area_response_; }  // (s, s)
  /// Phi^T of the load of these section pressures (s) Pa.
  Vector load(const Vector& pressure) const { return below_ + sections_ * pressure; }
  /// A^-1 Phi^T of 1 Pa at each section, (r, s).
  const Eigen::MatrixXd& response() const { return response_; }
  /// (s, 3) m, the points of the sections in the mid-coronal plane on the right fold, then on the left.
  Points coronal(const Vector& q) const;

 private:
  const Airflow& airflow_;
  Vector widths_, areas_;  // m, m^2, at rest
  Eigen::MatrixXd width_shapes_, sections_, response_, width_response_, area_shapes_, area_response_;
  Vector below_;                    // Phi^T of the load below the sections
  Points coronal_;                  // (2 s, 3) m, at rest
  Eigen::MatrixXd coronal_shapes_;  // (6 s, r)
};

}  // namespace plica

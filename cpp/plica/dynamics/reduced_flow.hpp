#pragma once
#include "plica/airflow/airflow.hpp"
#include "plica/core/panel_matrix.hpp"
#include "plica/dynamics/modal_motion.hpp"
#include "plica/dynamics/overlapping_widths.hpp"

namespace plica {

/// The airflow of a scene as its coordinates see it: loads of its sections are linear in their pressures, the
/// airway in the coordinates. The airway is a vector (a) m^2, m: the areas of the sections as if none of their widths
/// were negative, then x of the nodes that say which are.
class ReducedFlow {
 public:
  /// The airflow and the motions, of all nodes or a part and of the coordinates, must outlive it. Throws
  /// InvalidInput for a load on the current shape.
  ReducedFlow(const Airflow& airflow, const Motion& full, const ModalMotion& motion);

  const Airflow& airflow() const { return airflow_; }
  /// At coordinates q.
  Vector airway(const Vector& q) const { return airway_ + airway_shapes_ * q; }
  /// What coordinates q add to it.
  Vector airway_of(const Vector& q) const { return airway_shapes_ * q; }
  /// The same of response(), (a, s).
  const PanelMatrix& airway_response() const { return airway_response_; }
  /// (s) m^2, of an airway.
  Vector areas(const Vector& airway);
  /// Phi^T of the load of these section pressures (s) Pa.
  Vector load(const Vector& pressure) const { return below_ + sections_ * pressure; }
  /// What a change of them changes in it.
  Vector load_of(const Vector& change) const { return sections_ * change; }
  /// A^-1 Phi^T of 1 Pa at each section, (r, s).
  const Eigen::MatrixXd& response() const { return response_; }
  /// (s, 3) m, the points of the sections in the mid-coronal plane on the right or on the left fold.
  Points coronal(Side side, const Vector& q) const;

 private:
  /// Points that move with few nodes.
  struct Line {
    Points rest;         // (s, 3) m
    PanelMatrix shapes;  // (3 nodes, r), of their nodes
    struct Term {
      std::int32_t point, node;
      double weight;
    };
    std::vector<Term> terms;
  };
  static Line line(const std::vector<MaterialPoint>& points, const Motion& full, const ModalMotion& motion);

  const Airflow& airflow_;
  OverlappingWidths overlap_;
  Vector airway_;                                // at rest
  PanelMatrix airway_shapes_, airway_response_;  // (a, r), (a, s)
  PanelMatrix sections_;                         // (r, s)
  Eigen::MatrixXd response_;                     // (r, s)
  Vector below_;                                 // Phi^T of the load below the sections
  Line right_, left_;
};

}  // namespace plica

#pragma once
#include "plica/airflow/airflow.hpp"
#include "plica/core/panel_matrix.hpp"
#include "plica/dynamics/modal_motion.hpp"
#include "plica/dynamics/overlapping_widths.hpp"

namespace plica {

/// The airflow of a scene as its coordinates see it: loads of its sections are linear in their pressures, areas in
/// the coordinates but for what overlaps.
class ReducedFlow {
 public:
  /// The airflow and the motions, of all nodes or a part and of the coordinates, must outlive it. Throws
  /// InvalidInput for a load on the current shape.
  ReducedFlow(const Airflow& airflow, const Motion& full, const ModalMotion& motion);

  const Airflow& airflow() const { return airflow_; }
  /// (s) m^2 at coordinates q.
  Vector areas(const Vector& q);
  /// Phi^T of the load of these section pressures (s) Pa.
  Vector load(const Vector& pressure) const { return below_ + sections_ * pressure; }
  /// What a change of them changes in it.
  Vector load_of(const Vector& change) const { return sections_ * change; }
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
  Vector areas_;             // m^2, at rest, overlap as it counts where it does not count zero
  PanelMatrix area_shapes_;  // (s, r)
  PanelMatrix sections_;     // (r, s)
  Vector below_;             // Phi^T of the load below the sections
  Line right_, left_;
};

}  // namespace plica

#pragma once
#include <array>
#include <optional>

#include "plica/airflow/airflow.hpp"
#include "plica/dynamics/reduced_areas.hpp"

namespace plica {

/// The airflow of a scene in the coordinates of its reduction. Within a step all that section pressures move is
/// linear in them.
class ReducedFlow {
 public:
  /// The airflow must outlive it; `positions` has those of the airflow's nodes. ends: pressures below and above
  /// the sections change within a step. Throws InvalidInput for a load on the current shape.
  ReducedFlow(const Airflow& airflow, const Motion& full, const ModalMotion& motion, const Mediolateral& positions,
              bool ends);

  const Airflow& airflow() const { return airflow_; }
  /// (s) m^2 at mediolateral positions (n) m.
  Vector areas(const Vector& x) { return areas_.at(x); }
  /// (r) Phi^T of the load of 1 Pa below the sections, above them.
  const Vector& load_below() const { return below_; }
  const Vector& load_above() const { return above_; }
  /// Phi^T of the load of section pressures (s) Pa.
  void load(const Vector& pressure, Vector& found) const { sections_.multiply(pressure, found); }
  /// What moves the coordinates in a step that has begun under `begun`'s ends: (s) Pa of the sections, or (s + 2)
  /// with by how much the ends differ.
  Vector moving(const AirwayPressure& pressure, const AirwayPressure& begun) const;
  /// A^-1 of the load of that, (r), and what it moves of the positions, (n).
  void acceleration(const Vector& pressure, Vector& found) const { accelerations_.multiply(pressure, found); }
  void x_acceleration(const Vector& pressure, Eigen::VectorXf& found) const {
    x_accelerations_.multiply(pressure.cast<float>(), found);
  }
  /// How fast the airway gives way at the coordinates' velocity (r); the same at two; and what a velocity of
  /// `factor` (s) times the acceleration under such a pressure adds.
  AirwayExpansion expansion(const Vector& velocity) const {
    return {below_.dot(velocity), rates_ * velocity, above_.dot(velocity)};
  }
  std::array<AirwayExpansion, 2> expansions(const TwoColumns& velocities) const;
  void add_expansion(double factor, const Vector& pressure, AirwayExpansion& found) const;
  /// (s, 3) m, the points of the sections in the mid-coronal plane on the right or on the left fold.
  Points coronal(Side side, const Vector& q) const;

 private:
  /// Points that move with few nodes.
  struct Line {
    Points rest;         // (s, 3) m
    PanelMatrix shapes;  // (moving components, r) of their nodes
    struct Term {
      std::int32_t entry;      // 3 point + axis
      std::int32_t component;  // row of the shapes
      double weight;
    };
    std::vector<Term> terms;
  };
  static Line line(const std::vector<MaterialPoint>& points, const Motion& full, const ModalMotion& motion);

  const Airflow& airflow_;
  ReducedAreas areas_;
  bool ends_;
  Vector below_, above_;
  PanelMatrix sections_;       // (r, s)
  PanelMatrix accelerations_;  // (r, s), or (r, s + 2) with those of the ends
  PanelMatrix rates_;          // (s, r) m^2, of the airway's volume at each section
  PanelMatrix expansions_;     // (s + 2, as many as accelerations_) m^3/(s^2 Pa), of the sections, below, above
  SinglePanelMatrix
      x_accelerations_;  // (n, as many); 6e-8 of what pressures move in a step, 1e-13 m at 1 kPa and 50 us
  Line right_;
  std::optional<Line> left_;  // absent where it is the right one's mirror image
};

}  // namespace plica

#pragma once
#include <optional>

#include "plica/dynamics/motion.hpp"
#include "plica/dynamics/pressure_response.hpp"

namespace plica {

/// The airflow of a scene as its steps see it: positions (n, 3) m from the motion's origin, while the flow knows
/// the scene's coordinates.
class SceneFlow {
 public:
  /// The scene has an airflow.
  SceneFlow(const Scene& scene, const Motion& motion)
      : airflow_(scene.mesh, scene.mesh.surface(scene.airflow->surface), scene.airflow->flow),
        origin_(motion.origin()),
        images_(motion.images()) {
    fold_patterns();
  }

  const Airflow& airflow() const { return airflow_; }
  /// Solves for the response of these nodes where a coupling that iterates can use it: the load is linear in the
  /// pressures on the reference shape. `of_ends`: to those at the ends, too. Throws SolveFailed.
  void find_response(const Coupling& coupling, const Motion& motion, const Indices& nodes, bool of_ends) {
    if (std::holds_alternative<Iterated>(coupling) &&
        std::holds_alternative<Airflow::ReferenceShape>(airflow_.options().load_shape))
      response_.emplace(airflow_, motion, nodes, of_ends);
  }
  /// Null where it was not found.
  const PressureResponse* response() const { return response_ ? &*response_ : nullptr; }
  /// (s) m^2
  Vector areas(const Points& x) const { return origin_.isZero(0) ? airflow_.areas(x) : airflow_.areas(placed(x)); }
  /// How fast the airway gives way at the velocities of its nodes, velocity(node) m/s: asked for those of the
  /// part of which the others are images.
  template <class Velocity>
  AirwayExpansion expansion(const Velocity& velocity) const {
    Vector own(3 * own_nodes_.size());
    for (std::ptrdiff_t n = 0; n < own_nodes_.size(); ++n) own.segment<3>(3 * n) = velocity(own_nodes_[n]);
    return own_.expansion(own);
  }
  /// Adds the force of the pressure on the tissue at x to `load`, N, of the motion's unknowns.
  void add_load(const Points& x, const AirwayPressure& pressure, Vector& load) const {
    if (!images_) return add_load_everywhere(x, pressure, load);
    Vector everywhere = Vector::Zero(x.size());
    add_load_everywhere(x, pressure, everywhere);
    images_->add_folded(everywhere, airflow_.nodes(), load);
  }
  /// Whether contact at this place lies in the middle of the glottis (Paper A, Sec. 2.4).
  bool blocks(const Vector3& place) const { return airflow_.blocks(place[1] + origin_[1], place[2] + origin_[2]); }

 private:
  void add_load_everywhere(const Points& x, const AirwayPressure& pressure, Vector& load) const {
    if (origin_.isZero(0))
      airflow_.add_load(x, pressure, load);
    else
      airflow_.add_load(placed(x), pressure, load);
  }
  Points placed(const Points& x) const { return x.rowwise() + origin_.transpose(); }
  /// The load patterns of all images of a node, summed as it sees them.
  void fold_patterns();

  Airflow airflow_;
  Vector3 origin_;              // m
  const MirrorImages* images_;  // null where all nodes move on their own
  Indices own_nodes_;           // of the airway's, in the whole: those of the part
  LoadPatterns own_;            // of these
  std::optional<PressureResponse> response_;
};

}  // namespace plica

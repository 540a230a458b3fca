#pragma once
#include <optional>
#include <variant>

#include "plica/airflow/flow_model.hpp"
#include "plica/airflow/load_patterns.hpp"
#include "plica/airflow/pressure_course.hpp"
#include "plica/airflow/section_areas.hpp"
#include "plica/airflow/sections.hpp"

namespace plica {

/// One-dimensional flow through the sections of the deforming airway interface, and its load on it.
class Airflow {
 public:
  /// The pressure acts on the reference surface: consistent with linear tissue, whose displacement is small. The
  /// sections still follow the motion.
  struct ReferenceShape {};
  /// The pressure acts on the deformed surface, as in Paper A, Eq. (17). The load that then turns and grows with
  /// the surface softens it by about the pressure over the tissue's modulus at every wavelength: with 0.8 kPa on a
  /// cover of 1 kPa fine meshes fold (docs/theory/airflow.md).
  struct CurrentShape {};
  struct Options {
    double subglottal_pressure = Air{}.subglottal_pressure;  // Pa, > 0, from the end of its rise on
    double rise = 0.0;                                       // s, >= 0: how long the pressure rises from 0
    std::optional<PressureCourse> course;                    // the pressure over time, at most subglottal_pressure
    double air_density = Air{}.density;                      // kg/m^3, > 0
    std::variant<ViscousSlit, Bernoulli> model = ViscousSlit{};
    std::variant<CutSections, EllipticSections> area = CutSections{};
    std::variant<ReferenceShape, CurrentShape> load_shape = ReferenceShape{};
    double air_viscosity() const;  // Pa s, that of air where the model has none
    bool has_inertance() const;    // whether the air between the first and the last section has to be accelerated
    void validate() const;         // throws InvalidInput
  };

  /// surface: the whole airway interface of the mesh, outward (into the air). The mesh is copied as far as needed.
  Airflow(const TetMesh& mesh, const Faces& surface, Options options);

  const Options& options() const { return options_; }
  /// The air that drives the flow at time t (s): its pressure is p_s (1 - cos(pi t / rise)) / 2 until t = rise,
  /// p_s from then on, and continuous with its first derivative; p_s is that of the course at t, if there is one.
  /// All that drives the flow by time is here.
  Air air(double time) const;
  const Sections& sections() const { return sections_; }
  /// Surface node numbers, ascending: the rows of nodal_pressure and, three each, of load_patterns.
  const Indices& nodes() const { return nodes_; }
  /// (s) m^2 at positions x (n, 3), of which those of nodes() are read; elliptic ones may be negative where the
  /// folds overlap.
  Vector areas(const Points& x) const { return section_areas_.areas(section_areas_.widths(x)); }
  /// The widths that areas are made of: linear in positions.
  const SectionAreas& section_areas() const { return section_areas_; }
  /// The flow of this air through these areas (s), by the model: viscous_slit_flow or bernoulli_flow. `stopped`
  /// and `separation` are the latter's alone.
  FlowState evaluate(const Vector& areas, const Air& air, bool stopped = false,
                     std::optional<int> separation = std::nullopt, const AirwayExpansion* moving = nullptr) const;
  /// The same after the pressure's rise.
  FlowState evaluate(const Vector& areas, bool stopped = false,
                     std::optional<int> separation = std::nullopt) const {
    return evaluate(areas, air(options_.rise), stopped, separation);
  }
  /// Adds the consistent nodal force of the pressure on the interface at positions x to force (3 n), N (Eq. 17);
  /// curved six-node faces are integrated as they are. On the reference shape it is that of load_patterns; on the
  /// current one faces interpolate nodal_pressure.
  void add_load(const Points& x, const AirwayPressure& pressure, Vector& force) const;
  /// The load on the reference shape as a linear map of the section pressures.
  const LoadPatterns& load_patterns() const { return patterns_; }
  /// (surface nodes) Pa, interpolated between sections along the reference height.
  Vector nodal_pressure(const AirwayPressure& pressure) const;
  /// Whether contact can stop the flow, and the flow jump.
  bool stops_at_contact() const { return std::holds_alternative<Bernoulli>(options_.model); }
  /// Whether contact at height z_bc, anteroposterior y_bc stops the flow: within tau * y_i of the middle.
  bool blocks(double y_bc, double z_bc) const;

 private:
  enum class Region : std::int8_t { below, within, above };  // the sections
  struct Place {
    Region region;
    std::int32_t section;  // the one at or below
    double weight;         // of the next one
  };
  static double pressure_at(const Place& place, const AirwayPressure& pressure);

  Options options_;
  Sections sections_;
  SectionAreas section_areas_;
  Faces faces_;
  Faces face_rows_;            // rows of nodes_
  Indices nodes_;              // of the surface, ascending
  std::vector<Place> places_;  // of nodes_, by reference height
  LoadPatterns patterns_;
  Vector length_;             // (s) m, anteroposterior
  double closed_area_ = 0.0;  // m^2, Bernoulli: sections below it count as closed where the flow is stopped
};

}  // namespace plica

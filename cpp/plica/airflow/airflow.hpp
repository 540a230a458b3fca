#pragma once
#include <optional>
#include <variant>

#include "plica/airflow/sections.hpp"

namespace plica {

/// What the flow does at one instant.
struct FlowState {
  Vector area;           // (s) m^2, of each section
  Vector pressure;       // (s) Pa, at each section
  int separation = 0;    // section of least area, where the jet leaves the wall
  bool stopped = false;  // no flow: contact inside the middle of the glottis, or no area left
  double flow = 0.0;     // m^3/s
};

/// One-dimensional Bernoulli flow (Paper A, Sec. 2.1) on the deforming airway interface.
class Airflow {
 public:
  /// Sections as half-ellipses with their own minor half-axes, Paper A, Eq. (3).
  struct Elliptic {};
  /// Area cut from the deforming interface mesh in the plane of each section; the plane of a section beyond the
  /// current rim of the interface is moved to the rim.
  struct Cut {};
  /// The pressure acts on the reference surface: consistent with linear tissue, whose displacement is small. The
  /// sections still follow the motion.
  struct ReferenceShape {};
  /// The pressure acts on the deformed surface, as in Paper A, Eq. (17). The load that then turns and grows with
  /// the surface softens it by about the pressure over the tissue's modulus at every wavelength: with 0.8 kPa on a
  /// cover of 1 kPa fine meshes fold (docs/theory.md, "Airflow").
  struct CurrentShape {};
  struct Options {
    double subglottal_pressure = 800.0;  // Pa, > 0
    double air_density = 1.23;           // kg/m^3, > 0
    double zero_flow_fraction =
        0.5;  // tau of Paper A, Sec. 2.4: contact within tau * y_i of the middle stops the flow
    std::variant<Elliptic, Cut> area = Elliptic{};
    std::variant<ReferenceShape, CurrentShape> load_shape = ReferenceShape{};
    void validate() const;  // throws InvalidInput
  };

  /// surface: the whole airway interface of the mesh, outward (into the air). The mesh is copied as far as needed.
  Airflow(const TetMesh& mesh, const Faces& surface, Options options);

  const Options& options() const { return options_; }
  const Sections& sections() const { return sections_; }
  /// Surface node numbers, ascending: the rows of nodal_pressure.
  const Indices& nodes() const { return nodes_; }
  /// (s) m^2 at positions x (n, 3); may be negative where the folds overlap.
  Vector areas(const Points& x) const;
  /// p_i = p_s (1 - (a_min / a_i)^2) upstream of the separation, 0 from there on (Eqs. 1 and 2);
  /// stopped, or a_min <= 0: p_i = p_s upstream, 0 from there on, no flow.
  /// With a given `separation` both it and `stopped` are held, whatever the areas: a_min is then the area there
  /// (at least 0) and a ratio above 1 counts as 1, so that pressures are continuous in the areas and within [0,
  /// p_s].
  FlowState evaluate(const Vector& areas, bool stopped, std::optional<int> separation = std::nullopt) const;
  /// Adds the consistent nodal force of the pressure on the interface at positions x to force (3 n), N (Eq. 17);
  /// curved six-node faces are integrated as they are. `pressure` (s) Pa.
  void add_load(const Points& x, const Vector& pressure, Vector& force) const;
  /// (surface nodes) Pa, interpolated between sections along the reference height; p_s below the first section,
  /// 0 above the last.
  Vector nodal_pressure(const Vector& pressure) const;
  /// Whether contact at height z_bc, anteroposterior y_bc lies in the middle of the glottis: within tau * y_i of
  /// it.
  bool blocks(double y_bc, double z_bc) const;

 private:
  enum class Region : std::int8_t { below, within, above };  // the sections
  struct Place {
    Region region;
    std::int32_t section;  // the one at or below
    double weight;         // of the next one
  };
  double pressure_at(const Place& place, const Vector& pressure) const;

  Options options_;
  Points reference_;          // (n, 3) m
  double closed_area_ = 0.0;  // m^2, sections below it count as closed where the flow is stopped
  Sections sections_;
  Faces faces_;
  Faces face_rows_;                                  // rows of nodes_
  Indices nodes_;                                    // of the surface, ascending
  std::vector<Place> places_;                        // of nodes_, by reference height
  Triangles triangles_;                              // only for Cut
  std::vector<std::int32_t> lower_rim_, upper_rim_;  // only for Cut: lowest and highest nodes at rest
};

}  // namespace plica

#include "plica/airflow/airflow.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "plica/airflow/traction.hpp"
#include "plica/core/constants.hpp"
#include "plica/core/error.hpp"
#include "plica/core/require.hpp"

namespace plica {
namespace {

const Faces& checked(const TetMesh& mesh, const Faces& surface) {
  if (surface.rows() == 0) throw InvalidInput("Airflow", "faces of the surface", 0, "", "> 0");
  if (surface.cols() != 3 && surface.cols() != 6)
    throw InvalidInput("Airflow", "nodes of a face", static_cast<double>(surface.cols()), "", "3 or 6");
  for (const auto node : surface.reshaped())
    if (node < 0 || node >= mesh.node_count())
      throw InvalidInput("Airflow", "node of the surface", node, "",
                         "in [0, " + std::to_string(mesh.node_count()) + ")");
  return surface;
}

/// Where `at` lies between ascending values: at = (1 - t) values[i] + t values[i + 1], clamped to the ends.
struct Between {
  std::ptrdiff_t i;
  double t;
};
Between between(const Vector& values, double at) {
  const auto above = std::upper_bound(values.data(), values.data() + values.size(), at) - values.data();
  if (above == 0) return {0, 0};
  if (above == values.size()) return {values.size() - 1, 0};
  return {above - 1, (at - values[above - 1]) / (values[above] - values[above - 1])};
}
double interpolate(const Vector& values, const Between& where) {
  if (where.t == 0) return values[where.i];
  return (1 - where.t) * values[where.i] + where.t * values[where.i + 1];
}

}  // namespace

double Airflow::Options::air_viscosity() const {
  struct Of {
    double operator()(const ViscousSlit& slit) const { return slit.air_viscosity; }
    double operator()(const Bernoulli&) const { return Gas{}.viscosity; }
  };
  return std::visit(Of{}, model);
}

bool Airflow::Options::has_inertance() const {
  struct Of {
    bool operator()(const ViscousSlit& slit) const { return slit.inertance; }
    bool operator()(const Bernoulli&) const { return false; }
  };
  return std::visit(Of{}, model);
}

void Airflow::Options::validate() const {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto positive = [&](const char* name, double value, const char* unit) {
    if (!(value > 0 && value < infinity))
      throw InvalidInput("Airflow", name, value, unit, "> 0", "Is the unit right?");
  };
  positive("subglottal_pressure", subglottal_pressure, "Pa");
  positive("air_density", air_density, "kg/m^3");
  if (!(rise >= 0 && rise < infinity))
    throw InvalidInput("Airflow", "rise", rise, "s", ">= 0 and finite", "Is the unit right?");
  if (course) {
    course->validate();
    if (course->greatest() != subglottal_pressure)
      throw InvalidInput("Airflow", "subglottal_pressure", subglottal_pressure, "Pa",
                         "the greatest of the course, " + number_text(course->greatest()) + " Pa");
  }
  if (const auto* cut = std::get_if<CutSections>(&area))
    if (cut->sections < 2 || cut->sections > 1000)
      throw InvalidInput("Airflow", "sections", cut->sections, "", "in [2, 1000]");
  std::visit([](const auto& chosen) { chosen.validate(); }, model);
}

Airflow::Airflow(const TetMesh& mesh, const Faces& surface, Options options)
    : options_((options.validate(), options)), faces_(checked(mesh, surface)) {
  if (const auto* cut = std::get_if<CutSections>(&options_.area)) {
    sections_ = graded_sections(mesh, faces_, cut->sections);
    section_areas_ = SectionAreas::cut(mesh, faces_, sections_);
  } else {
    sections_ = level_sections(mesh, faces_);
    section_areas_ = SectionAreas::elliptic(sections_);
  }
  length_ = 2 * sections_.major;
  if (!(length_.minCoeff() > 0))
    throw InvalidInput("Airflow", "least anteroposterior length of a section", length_.minCoeff(), "m", "> 0",
                       "Take sections that are cut.");
  nodes_ = surface.reshaped<Eigen::RowMajor>();
  std::sort(nodes_.begin(), nodes_.end());
  nodes_.conservativeResize(std::unique(nodes_.begin(), nodes_.end()) - nodes_.begin());
  face_rows_ = faces_.unaryExpr([&](std::int32_t node) {
    return static_cast<std::int32_t>(std::lower_bound(nodes_.begin(), nodes_.end(), node) - nodes_.begin());
  });

  // Heights closer than sections can be are one: round-off must not move a node off the first or last section.
  const Points x = mesh.points(nodes_, Eigen::all);
  const double same = 1e-6 * (x.col(2).maxCoeff() - x.col(2).minCoeff());
  const Vector& height = sections_.height;
  for (const double z : x.col(2)) {
    if (z < height[0] - same)
      places_.push_back({Region::below, 0, 0});
    else if (z > height[height.size() - 1] + same)
      places_.push_back({Region::above, 0, 0});
    else {
      const auto [i, t] = between(height, z);
      places_.push_back({Region::within, static_cast<std::int32_t>(i), t});
    }
  }
  patterns_ = plica::load_patterns(x, face_rows_, height, same);
  constexpr double closed = 1e-4;  // of the least area at rest; exact contact leaves about 1e-6
  closed_area_ = closed * std::max(areas(mesh.points).minCoeff(), 0.0);
}

Air Airflow::air(double time) const {
  const double pressure = options_.course ? options_.course->at(time) : options_.subglottal_pressure;
  const double rise = options_.rise;
  if (rise == 0 || time >= rise) return {pressure, options_.air_density};
  const double sine = std::sin(0.5 * pi * std::max(time, 0.0) / rise);
  return {pressure * sine * sine, options_.air_density};  // 1 - cos would cancel early on
}

FlowState Airflow::evaluate(const Vector& areas, const Air& air, bool stopped, std::optional<int> separation,
                            const AirwayExpansion* moving) const {
  if (areas.size() != sections_.count())
    throw InvalidInput("Airflow", "number of areas", static_cast<double>(areas.size()), "",
                       "the number of sections, " + std::to_string(sections_.count()));
  if (!areas.allFinite())
    throw InvalidInput("Airflow: areas are not finite; must be finite. Did the time step diverge?");
  if (separation && (*separation < 0 || *separation >= areas.size()))
    throw InvalidInput("Airflow", "separation", *separation, "", "in [0, " + std::to_string(areas.size()) + ")");
  return std::visit(
      [&](const auto& model) {
        using Model = std::decay_t<decltype(model)>;
        if constexpr (std::is_same_v<Model, ViscousSlit>) {
          return viscous_slit_flow(model, air, {sections_.height, length_}, areas, moving);
        } else {
          static_assert(std::is_same_v<Model, Bernoulli>);
          return bernoulli_flow(air, closed_area_, areas, stopped, separation, moving);
        }
      },
      options_.model);
}

double Airflow::pressure_at(const Place& place, const AirwayPressure& pressure) {
  if (place.region == Region::below) return pressure.below;
  if (place.region == Region::above) return pressure.above;
  return interpolate(pressure.sections, {place.section, place.weight});
}

Vector Airflow::nodal_pressure(const AirwayPressure& pressure) const {
  require_size("Airflow", "pressure", pressure.sections.size(), sections_.count());
  Vector nodal(nodes_.size());
  for (std::ptrdiff_t n = 0; n < nodal.size(); ++n) nodal[n] = pressure_at(places_[n], pressure);
  return nodal;
}

void Airflow::add_load(const Points& x, const AirwayPressure& pressure, Vector& force) const {
  require_size("Airflow", "pressure", pressure.sections.size(), sections_.count());
  require_at_least("Airflow", "x", x.rows(), nodes_[nodes_.size() - 1] + std::ptrdiff_t{1});
  require_size("Airflow", "force", force.size(), x.size());
  auto forces = as_points(force);
  if (std::holds_alternative<ReferenceShape>(options_.load_shape)) {
    Vector load = pressure.below * patterns_.below + patterns_.sections * pressure.sections;
    if (pressure.above != 0) load += pressure.above * patterns_.above;
    for (std::ptrdiff_t n = 0; n < nodes_.size(); ++n) forces.row(nodes_[n]) += load.segment<3>(3 * n).transpose();
    return;
  }
  FaceVectors position(faces_.cols(), 3);
  FaceValues value(faces_.cols());
  for (std::ptrdiff_t f = 0; f < faces_.rows(); ++f) {
    for (std::ptrdiff_t c = 0; c < faces_.cols(); ++c) {
      position.row(c) = x.row(faces_(f, c));
      value[c] = pressure_at(places_[face_rows_(f, c)], pressure);
    }
    if ((value.array() == 0).all()) continue;  // downstream of the separation
    const FaceVectors load = pressure_load(position, value);
    for (std::ptrdiff_t c = 0; c < faces_.cols(); ++c) forces.row(faces_(f, c)) += load.row(c);
  }
}

bool Airflow::blocks(double y_bc, double z_bc) const {
  const auto* bernoulli = std::get_if<Bernoulli>(&options_.model);
  if (bernoulli == nullptr) return false;
  const Between where = between(sections_.height, z_bc);
  return std::abs(y_bc - interpolate(sections_.middle, where)) <=
         bernoulli->zero_flow_fraction * interpolate(sections_.major, where);
}

}  // namespace plica

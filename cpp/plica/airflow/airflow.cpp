#include "plica/airflow/airflow.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "plica/airflow/traction.hpp"
#include "plica/core/error.hpp"

namespace plica {
namespace {

constexpr double pi = 3.14159265358979323846;

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

void Airflow::Options::validate() const {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto positive = [&](const char* name, double value, const char* unit) {
    if (!(value > 0 && value < infinity))
      throw InvalidInput("Airflow", name, value, unit, "> 0", "Is the unit right?");
  };
  positive("subglottal_pressure", subglottal_pressure, "Pa");
  positive("air_density", air_density, "kg/m^3");
  if (!(zero_flow_fraction >= 0 && zero_flow_fraction <= 1))
    throw InvalidInput("Airflow", "zero_flow_fraction", zero_flow_fraction, "", "in [0, 1]");
}

Airflow::Airflow(const TetMesh& mesh, const Faces& surface, Options options)
    : options_((options.validate(), options)),
      reference_(mesh.points),
      sections_(coronal_sections(mesh, checked(mesh, surface))),
      faces_(surface) {
  nodes_ = surface.reshaped<Eigen::RowMajor>();
  std::sort(nodes_.begin(), nodes_.end());
  nodes_.conservativeResize(std::unique(nodes_.begin(), nodes_.end()) - nodes_.begin());
  face_rows_ = faces_.unaryExpr([&](std::int32_t node) {
    return static_cast<std::int32_t>(std::lower_bound(nodes_.begin(), nodes_.end(), node) - nodes_.begin());
  });

  // Heights closer than sections can be are one: round-off must not move a node off the first or last section.
  const double same = 1e-6 * (mesh.points(nodes_, 2).maxCoeff() - mesh.points(nodes_, 2).minCoeff());
  const Vector& height = sections_.height;
  for (const auto node : nodes_) {
    const double z = mesh.points(node, 2);
    if (z < height[0] - same)
      places_.push_back({Region::below, 0, 0});
    else if (z > height[height.size() - 1] + same)
      places_.push_back({Region::above, 0, 0});
    else {
      const auto [i, t] = between(height, z);
      places_.push_back({Region::within, static_cast<std::int32_t>(i), t});
    }
  }
  if (std::holds_alternative<Cut>(options_.area)) {
    triangles_ = flat_triangles(faces_);
    const Vector z = mesh.points(nodes_, 2);
    for (std::ptrdiff_t n = 0; n < nodes_.size(); ++n) {
      if (z[n] <= z.minCoeff() + same) lower_rim_.push_back(nodes_[n]);
      if (z[n] >= z.maxCoeff() - same) upper_rim_.push_back(nodes_[n]);
    }
  }
  constexpr double closed = 1e-4;  // of the least area at rest; exact contact leaves about 1e-6
  closed_area_ = closed * std::max(areas(reference_).minCoeff(), 0.0);
}

Vector Airflow::areas(const Points& x) const {
  if (std::holds_alternative<Elliptic>(options_.area))
    return pi / 2 * sections_.major.cwiseProduct(sections_.widths(x));
  double low = -std::numeric_limits<double>::infinity(), high = -low;
  for (const auto node : lower_rim_) low = std::max(low, x(node, 2));
  for (const auto node : upper_rim_) high = std::min(high, x(node, 2));
  return cut_areas(x, triangles_, sections_.height.cwiseMax(low).cwiseMin(high));
}

FlowState Airflow::evaluate(const Vector& areas, bool stopped, std::optional<int> separation) const {
  if (areas.size() != sections_.count())
    throw InvalidInput("Airflow", "number of areas", static_cast<double>(areas.size()), "",
                       "the number of sections, " + std::to_string(sections_.count()));
  if (!areas.allFinite())
    throw InvalidInput("Airflow: areas are not finite; must be finite. Did the time step diverge?");
  if (separation && (*separation < 0 || *separation >= areas.size()))
    throw InvalidInput("Airflow", "separation", *separation, "", "in [0, " + std::to_string(areas.size()) + ")");
  FlowState state;
  state.area = areas;
  std::ptrdiff_t least = 0;
  const double least_area = areas.minCoeff(&least);
  state.stopped = stopped;
  if (separation) {
    state.separation = *separation;
  } else {
    state.stopped = stopped || least_area <= 0;
    // Where the folds touch, several sections are closed to round-off: the flow meets the lowest of them first.
    if (state.stopped)
      least = std::find_if(areas.begin(), areas.end(),
                           [&](double a) { return a <= std::max(least_area, 0.0) + closed_area_; }) -
              areas.begin();
    state.separation = static_cast<int>(least);
  }
  const double throat = state.stopped ? 0 : std::max(areas[state.separation], 0.0);
  state.pressure = Vector::Zero(areas.size());
  for (int i = 0; i < state.separation; ++i) {
    const double ratio = throat < areas[i] ? throat / areas[i] : (throat > 0 ? 1.0 : 0.0);
    state.pressure[i] = options_.subglottal_pressure * (1 - ratio * ratio);
  }
  state.flow = std::sqrt(2 * options_.subglottal_pressure / options_.air_density) * throat;
  return state;
}

double Airflow::pressure_at(const Place& place, const Vector& pressure) const {
  if (place.region == Region::below) return options_.subglottal_pressure;
  if (place.region == Region::above) return 0;
  return interpolate(pressure, {place.section, place.weight});
}

Vector Airflow::nodal_pressure(const Vector& pressure) const {
  Vector nodal(nodes_.size());
  for (std::ptrdiff_t n = 0; n < nodal.size(); ++n) nodal[n] = pressure_at(places_[n], pressure);
  return nodal;
}

void Airflow::add_load(const Points& x, const Vector& pressure, Vector& force) const {
  const Points& shape = std::holds_alternative<ReferenceShape>(options_.load_shape) ? reference_ : x;
  FaceVectors position(faces_.cols(), 3);
  FaceValues value(faces_.cols());
  auto forces = as_points(force);
  for (std::ptrdiff_t f = 0; f < faces_.rows(); ++f) {
    for (std::ptrdiff_t c = 0; c < faces_.cols(); ++c) {
      position.row(c) = shape.row(faces_(f, c));
      value[c] = pressure_at(places_[face_rows_(f, c)], pressure);
    }
    if ((value.array() == 0).all()) continue;  // downstream of the separation
    const FaceVectors load = pressure_load(position, value);
    for (std::ptrdiff_t c = 0; c < faces_.cols(); ++c) forces.row(faces_(f, c)) += load.row(c);
  }
}

bool Airflow::blocks(double y_bc, double z_bc) const {
  const Between where = between(sections_.height, z_bc);
  return std::abs(y_bc - interpolate(sections_.middle, where)) <=
         options_.zero_flow_fraction * interpolate(sections_.major, where);
}

}  // namespace plica

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "../approx.hpp"
#include "plica/airflow/airflow.hpp"
#include "plica/airflow/load_patterns.hpp"
#include "plica/core/error.hpp"
#include "plica/mesh/larynx.hpp"
#include "tube.hpp"

using namespace plica;

namespace {

const std::vector<double> levels{-2e-2, -1e-2, -0.25e-2, 0.5e-2, 1e-2};
double narrowing(double z) { return 0.2e-2 - 0.1 * z; }  // m, half-axis
TetMesh duct() { return tube(16, levels, narrowing, 0.7e-2); }

/// The thesis's flow.
Airflow::Options thesis() {
  Airflow::Options options;
  options.model = Bernoulli{};
  options.area = EllipticSections{};
  return options;
}

std::string message_of(const Airflow::Options& options) {
  try {
    options.validate();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

/// Area of the polygon through the nodes at one height, by the shoelace formula around the axis.
double ring_area(const TetMesh& mesh, const Indices& nodes, double height) {
  std::map<double, Vector3> ring;  // by angle
  for (const auto node : nodes) {
    const Vector3 p = mesh.points.row(node).transpose();
    if (std::abs(p[2] - height) < 1e-12) ring[std::atan2(p[1], p[0])] = p;
  }
  double twice = 0;
  Vector3 last = ring.rbegin()->second;
  for (const auto& [angle, p] : ring) {
    twice += last[0] * p[1] - last[1] * p[0];
    last = p;
  }
  return twice / 2;
}

/// Force on the whole interface.
Vector3 total(const Vector& force) { return as_points(force).colwise().sum().transpose(); }

}  // namespace

TEST_CASE("the larynx has one section at each level, one node on each side") {
  const Larynx larynx = Larynx::thesis_coarse();
  const TetMesh mesh = larynx_mesh(larynx);
  for (const bool quadratic : {false, true}) {
    const TetMesh used = quadratic ? to_quadratic(mesh) : mesh;
    const Airflow airflow(used, used.surface("airway"), thesis());
    int levels_of_larynx = 1;
    for (const int n : std::get<Larynx::Levels>(larynx.meshed).levels) levels_of_larynx += quadratic ? 2 * n : n;
    CHECK(airflow.sections().count() == levels_of_larynx);
    for (const auto* side : {&airflow.sections().right, &airflow.sections().left})
      for (const auto& point : *side) CHECK(point.nodes.size() == 1);
    CHECK(airflow.sections().major.minCoeff() == approx(larynx.shape.major).epsilon(1e-12));
    CHECK(airflow.sections().major.maxCoeff() == approx(larynx.shape.major).epsilon(1e-12));
  }
}

TEST_CASE("areas of half-ellipses and of cut sections differ by the polygon and by the spacing of the stations") {
  // Flat faces, so that the airway is a polygon of 64 sides, between whose levels the facets leave the ruled
  // surface.
  const TetMesh mesh = tube(
      64, levels, [](double) { return 0.2e-2; }, 0.7e-2);
  Airflow::Options options = thesis();
  const Airflow elliptic(mesh, mesh.surface("airway"), options);
  options.area = CutSections{7};
  const Airflow cut(mesh, mesh.surface("airway"), options);
  const Vector a = elliptic.areas(mesh.points), b = cut.areas(mesh.points);
  const double pi = std::acos(-1.0);
  CHECK(a.size() == 5);
  CHECK(b.size() == 7);
  for (const double area : a) CHECK(area == approx(pi * 0.7e-2 * 0.2e-2).epsilon(1e-13));
  // 32 stations: sin(pi / 64) / (pi / 64) of an ellipse, to the chords' part of the sum.
  const double spacing = std::sin(pi / 64) / (pi / 64);
  for (const double area : b) {
    CHECK(area == approx(inscribed(64, 0.2e-2, 0.7e-2) * spacing).epsilon(1e-3));
    CHECK(area < inscribed(64, 0.2e-2, 0.7e-2));
  }
}

TEST_CASE("a straight slit has its whole area where it is cut, and pi / 4 of it where it is an ellipse") {
  const double width = 1e-3, length = 14e-3, height = 5e-3;
  const TetMesh mesh = slit(width, length, height);
  Airflow::Options options = thesis();
  const Airflow elliptic(mesh, mesh.surface("airway"), options);
  options.area = CutSections{5};
  const Airflow cut(mesh, mesh.surface("airway"), options);
  for (const double area : cut.areas(mesh.points)) CHECK(area == approx(width * length).epsilon(1e-7));
  for (const double area : elliptic.areas(mesh.points))
    CHECK(area == approx(std::acos(-1.0) / 4 * width * length).epsilon(1e-12));
}

TEST_CASE(
    "the viscous flow of a slit is that of its anteroposterior length, 14 mm, however its area is measured") {
  const double length = 14e-3;
  const TetMesh mesh = slit(1e-3, length, 5e-3);
  Airflow::Options options;
  options.model = ViscousSlit{};
  for (const bool cut : {true, false}) {
    CAPTURE(cut);
    if (cut)
      options.area = CutSections{5};
    else
      options.area = EllipticSections{};
    const Airflow airflow(mesh, mesh.surface("airway"), options);
    const Vector& height = airflow.sections().height;
    const Vector areas = Vector::Constant(height.size(), 5e-5 * length),
                 lengths = Vector::Constant(height.size(), length);
    const double expected = viscous_slit_flow(ViscousSlit{}, airflow.air(0), {height, lengths}, areas).flow;
    CHECK(airflow.evaluate(areas).flow == approx(expected).epsilon(1e-9));
    const Vector half = 0.5 * lengths;  // which is seen: friction goes with the cube of the mean gap
    CHECK(viscous_slit_flow(ViscousSlit{}, airflow.air(0), {height, half}, areas).flow > 1.1 * expected);
  }
}

TEST_CASE("a face above the last section bears the pressure there alone, one below the first that below") {
  Points x(3, 3);
  x << 0, 0, 0, 0, 1, 0, 0, 0, 1;  // m; half a square metre, outward along x
  Faces face(1, 3);
  face << 0, 1, 2;
  const auto loads = [&](double low, double high) {
    const Vector height = Vector::LinSpaced(2, low, high);
    const LoadPatterns patterns = load_patterns(x, face, height, 1e-9);
    return std::array{Vector3(total(patterns.below)), Vector3(total(patterns.sections * Vector::Ones(2))),
                      Vector3(total(patterns.above))};
  };
  const Vector3 whole(-0.5, 0, 0);
  const std::array cases = {loads(2, 3), loads(-1, 2), loads(-2, -1)};  // the face is below, within, above
  for (std::size_t is = 0; is < 3; ++is)
    for (std::size_t part = 0; part < 3; ++part)
      CHECK((cases[is][part] - (part == is ? whole : Vector3::Zero())).norm() < (part == is ? 1e-14 : 1e-300));
}

TEST_CASE("the cut areas of the larynx at rest are those of its planes, whatever the levels") {
  const TetMesh mesh = larynx_mesh(Larynx::thesis_coarse());
  const Triangles wall = mesh.surface("airway");
  Airflow::Options options;
  options.area = CutSections{23};
  const Airflow airflow(mesh, wall, options);
  const Vector areas = airflow.areas(mesh.points);
  REQUIRE(areas.size() == 23);
  // Each side of the polygons of twelve has few stations.
  for (int i = 0; i < 23; ++i)
    CHECK(areas[i] == approx(cut_area(mesh.points, wall, airflow.sections().height[i])).epsilon(6e-3));
  // Dense where the glottis is narrow: the smallest spacing is at the least area.
  std::ptrdiff_t least = -1, nearest = -1;
  areas.minCoeff(&least);
  const Vector& z = airflow.sections().height;
  const Vector spacing = z.tail(22) - z.head(22);
  CHECK(spacing.minCoeff(&nearest) > 0);
  CHECK(std::abs(nearest - least) <= 2);
  CHECK(spacing.maxCoeff() > 5 * spacing.minCoeff());
}

TEST_CASE("cut sections of a surface with a hole in one fold are refused, whichever it is") {
  const TetMesh mesh = slit(1e-3, 14e-3, 5e-3);
  const Faces& wall = mesh.surface("airway");
  CHECK_NOTHROW(Airflow(mesh, wall, {}));
  for (const double side : {1.0, -1.0}) {
    CAPTURE(side);
    std::vector<std::ptrdiff_t> kept;
    for (std::ptrdiff_t f = 0; f < wall.rows(); ++f) {
      const Vector3 at = mesh.points(wall.row(f), Eigen::all).colwise().mean();
      const bool hole = side * at[0] > 0 && at[1] > 3.5e-3 && at[1] < 5.2e-3 && at[2] > 2.5e-3 && at[2] < 3.7e-3;
      if (!hole) kept.push_back(f);
    }
    REQUIRE(static_cast<std::ptrdiff_t>(kept.size()) == wall.rows() - 2);
    const Faces open = wall(kept, Eigen::all);
    CHECK_THROWS_WITH_AS(Airflow(mesh, open, {}), doctest::Contains("must be met equally often"), InvalidInput);
  }
}

TEST_CASE("cut sections follow a motion, and what overlaps counts zero") {
  const TetMesh mesh = slit(1e-3, 14e-3, 5e-3);
  const Airflow airflow(mesh, mesh.surface("airway"), {});
  const auto closed_by = [&](const auto& way) {
    Points x = mesh.points;
    for (auto point : x.rowwise())
      if (point[0] > 0) point[0] -= way(point[1]);
    return airflow.areas(x);
  };
  const Vector open = airflow.areas(mesh.points);
  const Vector half = closed_by([](double) { return 0.5e-3; }), shut = closed_by([](double) { return 1.5e-3; });
  CHECK((half - open / 2).cwiseAbs().maxCoeff() < 1e-6 * open[0]);
  CHECK(shut.isZero(0));
  // Stations lie alike on both sides of the middle: a width that is linear in y has its mean.
  const Vector tilted = closed_by([](double y) { return 0.25e-3 + 0.5e-3 * y / 7e-3; });
  CHECK((tilted - 0.75 * open).cwiseAbs().maxCoeff() < 1e-6 * open[0]);
  // Overlap over one half of the length does not take from the other: width 1 mm - 2 mm * y / 7 mm.
  const Vector partly = closed_by([](double y) { return 2e-3 * y / 7e-3; });
  const double expected = 3e-3 / 2 * 10.5e-3;          // open from y = -7 mm (3 mm wide) to 3.5 mm
  CHECK(partly[0] == approx(expected).epsilon(2e-3));  // the last station's share
  Points along = mesh.points;
  along.col(2).array() += 1e-3;
  CHECK((airflow.areas(along) - open).isZero(0));  // carried by the tissue
}

TEST_CASE("each half-ellipse has its own minor half-axis and becomes negative by overlap") {
  const TetMesh mesh = duct();
  const Airflow airflow(mesh, mesh.surface("airway"), thesis());
  Points x = mesh.points;
  for (auto point : x.rowwise())
    if (point[0] > 1e-9) point[0] -= 0.5e-2;
  const Vector change = airflow.areas(x) - airflow.areas(mesh.points);
  CHECK(change.isConstant(-std::acos(-1.0) / 2 * 0.7e-2 * 0.5e-2, 1e-12));
  CHECK(airflow.areas(x)[4] < 0);
}

TEST_CASE("pressure falls by the square of the area ratio and is zero from the separation on") {
  const TetMesh mesh = duct();
  const Airflow airflow(mesh, mesh.surface("airway"), thesis());
  Vector area(5);
  area << 4, 3, 1, 2, 1;
  const FlowState state = airflow.evaluate(area, false);
  CHECK(state.separation == 2);  // the first of equal ones
  for (int i = 0; i < 5; ++i)
    CHECK(state.pressure[i] == approx(i < 2 ? 800 * (1 - 1 / (area[i] * area[i])) : 0.0));
}

TEST_CASE("a stopped or closed glottis holds the subglottal pressure up to the section of least area") {
  const TetMesh mesh = duct();
  const Airflow airflow(mesh, mesh.surface("airway"), thesis());
  Vector area(5), overlapping(5), held(5);
  area << 4, 3, 2, 1, 5;
  overlapping << 4, 3, 0.5, -0.1, 5;
  held << 800, 800, 800, 0, 0;
  for (const FlowState& state : {airflow.evaluate(area, true), airflow.evaluate(overlapping, false)}) {
    CHECK(state.stopped);
    CHECK(state.flow == 0);
    CHECK(state.pressure == held);
  }
  // Sections that contact closes to round-off: the flow meets the lowest of them.
  const Vector rest = airflow.areas(mesh.points);
  area << 4, 3, 1e-6, 0, 5;
  area *= rest.minCoeff();
  held << 800, 800, 0, 0, 0;
  CHECK(airflow.evaluate(area, false).pressure == held);
}

TEST_CASE("with a given separation the pressure is continuous in the areas and stays within its bounds") {
  const TetMesh mesh = duct();
  const Airflow airflow(mesh, mesh.surface("airway"), thesis());
  Vector area(5);
  area << 4, 3, 1.0, 1.0, 5;
  const double e = 1e-9;
  Vector first = area, second = area;
  first[2] -= e;
  second[3] -= e;
  const FlowState a = airflow.evaluate(first, false, 3), b = airflow.evaluate(second, false, 3);
  CHECK(a.separation == 3);
  CHECK((a.pressure - b.pressure).cwiseAbs().maxCoeff() <
        800 * 4 * e);  // derivative of (a_min / a)^2 is at most 2
  CHECK(airflow.evaluate(first, false).separation != airflow.evaluate(second, false).separation);
  first[2] = 1e-6;
  CHECK(airflow.evaluate(first, false, 3).pressure.minCoeff() >= 0);
  CHECK(airflow.evaluate(first, false, 3).pressure.maxCoeff() <= 800);
  CHECK_THROWS_AS(airflow.evaluate(area, false, 5), InvalidInput);
  CHECK_THROWS_AS(airflow.evaluate(area.head(4), false), InvalidInput);
  area[1] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(airflow.evaluate(area, false), InvalidInput);
}

TEST_CASE("nodes take the pressure of their reference height") {
  // Right fold from level 1 to 4, left fold from level 0 to 3: sections between 1 and 3.
  TetMesh mesh = duct();
  std::vector<std::int32_t> faces;
  for (const auto& t : mesh.surface("airway").rowwise()) {
    const Vector3 middle = (mesh.points.row(t[0]) + mesh.points.row(t[1]) + mesh.points.row(t[2])).transpose() / 3;
    if (middle[0] > 0 ? middle[2] > levels[1] : middle[2] < levels[3])
      faces.insert(faces.end(), t.begin(), t.end());
  }
  const Faces part = Eigen::Map<const Faces>(faces.data(), static_cast<std::ptrdiff_t>(faces.size()) / 3, 3);
  mesh.points.middleRows(33, 7).col(2).array() -= 0.25e-2;  // part of a ring between levels 1 and 2, off y = 0
  const Airflow airflow(mesh, part, thesis());
  REQUIRE(airflow.sections().count() == 3);
  Vector pressure(3);
  pressure << 600, 500, 100;
  const Vector nodal = airflow.nodal_pressure({800, pressure});
  REQUIRE(nodal.size() == airflow.nodes().size());
  std::set<double> seen;
  for (int i = 0; i < nodal.size(); ++i) {
    const double z = mesh.points(airflow.nodes()[i], 2);
    double expected = 500 + 100.0 / 3;  // the moved nodes: a third of the way from level 2 to level 1
    if (z < levels[1]) expected = 800;
    if (z > levels[3]) expected = 0;
    if (z == levels[1]) expected = 600;
    if (z == levels[2]) expected = 500;
    if (z == levels[3]) expected = 100;
    CHECK(nodal[i] == approx(expected).epsilon(1e-14));
    seen.insert(expected);
  }
  CHECK(seen.size() == 6);
}

TEST_CASE("the load balances the open ends, is added to what is there, and takes the shape asked for") {
  Larynx larynx = Larynx::thesis_coarse();
  larynx.shape.sections.front().minor *= 0.5;  // ends of different areas
  const TetMesh linear = larynx_mesh(larynx);
  for (const bool quadratic : {false, true}) {
    const TetMesh mesh = quadratic ? to_quadratic(linear) : linear;
    Airflow::Options options = thesis();
    options.load_shape = Airflow::CurrentShape{};
    const Airflow airflow(mesh, mesh.surface("airway"), options);
    options.load_shape = Airflow::ReferenceShape{};
    const Airflow at_rest(mesh, mesh.surface("airway"), options);
    const Vector pressure = Vector::Constant(airflow.sections().count(), 800);
    Vector force = Vector::Zero(mesh.points.size());
    airflow.add_load(mesh.points, {800, pressure}, force);
    // By the closed surface under constant pressure: the sides balance, and the open ends leave F_z = p times the
    // area of the lower end less that of the upper end (a duct that widens upward is pushed down).
    const Vector& height = airflow.sections().height;
    const double ends =
        ring_area(mesh, airflow.nodes(), height[0]) - ring_area(mesh, airflow.nodes(), height[height.size() - 1]);
    CHECK((total(force) - Vector3(0, 0, 800 * ends)).norm() < 1e-12 * std::abs(800 * ends));
    CHECK(force.norm() > 1e-3);
    Vector twice = force;
    airflow.add_load(mesh.points, {800, pressure}, twice);
    CHECK((twice - 2 * force).norm() < 1e-15 * force.norm() * 10);
    Points moved = 2 * mesh.points;
    Vector larger = Vector::Zero(force.size());
    airflow.add_load(moved, {800, pressure}, larger);
    CHECK((larger - 4 * force).norm() < 1e-13 * force.norm());  // the current area
    Vector same = Vector::Zero(force.size());
    at_rest.add_load(moved, {800, pressure}, same);
    CHECK((same - force).norm() < 1e-13 * force.norm());  // another order of the same sums
  }
}

TEST_CASE("contact blocks the flow in the middle part of the glottis only") {
  const TetMesh mesh = duct();
  const Airflow airflow(mesh, mesh.surface("airway"), thesis());
  CHECK(airflow.blocks(0.349e-2, 0.2e-2));
  CHECK(airflow.blocks(-0.349e-2, -9));  // beyond the last section its depth holds
  CHECK(!airflow.blocks(0.351e-2, 0.2e-2));
  CHECK(!airflow.blocks(-0.351e-2, 9));
}

TEST_CASE("the middle of the glottis is where the glottis is") {
  TetMesh mesh = duct();
  mesh.points.col(1).array() += 3;
  const Airflow airflow(mesh, mesh.surface("airway"), thesis());
  CHECK(airflow.blocks(3 + 0.349e-2, 0.2e-2));
  CHECK(airflow.blocks(3 - 0.349e-2, 0.2e-2));
  CHECK(!airflow.blocks(3 + 0.351e-2, 0.2e-2));
  CHECK(!airflow.blocks(3 - 0.351e-2, 0.2e-2));
  CHECK(!airflow.blocks(0, 0.2e-2));
}

TEST_CASE("a larynx that is turned by half a turn has the folds that its cells are labelled with") {
  const TetMesh mesh = larynx_mesh(Larynx::thesis_coarse());
  TetMesh turned = mesh, bare = mesh;
  turned.points.leftCols<2>() *= -1;
  bare.points = turned.points;
  bare.cell_side.setZero();
  const Airflow straight(mesh, mesh.surface("airway"), thesis()),
      airflow(turned, turned.surface("airway"), thesis());
  const Sections &before = straight.sections(), &after = airflow.sections();
  CHECK(before.toward_right == 1);
  CHECK(after.toward_right == -1);
  for (std::ptrdiff_t i = 0; i < before.count(); ++i) {
    CHECK(after.right[i].nodes == before.right[i].nodes);
    CHECK(after.left[i].nodes == before.left[i].nodes);
  }
  CHECK((airflow.areas(turned.points) - straight.areas(mesh.points)).norm() == 0);
  // Without labels right is where x is larger.
  const Airflow by_place(bare, bare.surface("airway"), thesis());
  CHECK(by_place.sections().toward_right == 1);
  CHECK(by_place.sections().right[0].nodes == before.left[0].nodes);
}

TEST_CASE("options out of range say what they must be") {
  Airflow::Options options;
  CHECK(message_of(options) == "");
  options.subglottal_pressure = -800;
  CHECK(message_of(options) == "Airflow: subglottal_pressure = -800 Pa; must be > 0. Is the unit right?");
  options = {};
  options.air_density = 0;
  CHECK(message_of(options).find("air_density = 0 kg/m^3") != std::string::npos);
  options = {};
  options.model = Bernoulli{1.5};
  CHECK(message_of(options) == "Bernoulli: zero_flow_fraction = 1.5; must be in [0, 1].");
  options.model = ViscousSlit{1.0, 1.8e-5, 3e-4};
  CHECK(message_of(options) == "ViscousSlit: separation_ratio = 1; must be in (1, 2]. 1.1 to 1.3 are in use.");
  options.model = ViscousSlit{1.2, 1.8, 3e-4};
  CHECK(message_of(options).find("air_viscosity = 1.8 Pa s") != std::string::npos);
  options.model = ViscousSlit{1.2, 1.8e-5, 0};
  CHECK(message_of(options).find("least_gap = 0") != std::string::npos);
  options = {};
  options.area = CutSections{1};
  CHECK(message_of(options) == "Airflow: sections = 1; must be in [2, 1000].");
  const TetMesh mesh = duct();
  CHECK_THROWS_AS(Airflow(mesh, Faces(0, 3), {}), InvalidInput);
  Faces outside = mesh.surface("airway");
  outside(3, 1) = 80;
  CHECK_THROWS_AS(Airflow(mesh, outside, {}), InvalidInput);
}

TEST_CASE("the load of linear faces between levels is that of their nodal pressures") {
  const TetMesh mesh = larynx_mesh(Larynx::thesis_coarse());
  Airflow::Options options = thesis();
  const Airflow at_rest(mesh, mesh.surface("airway"), options);
  options.load_shape = Airflow::CurrentShape{};
  const Airflow by_nodes(mesh, mesh.surface("airway"), options);
  const FlowState flow = at_rest.evaluate(at_rest.areas(mesh.points));
  Vector one = Vector::Zero(mesh.points.size()), other = one;
  at_rest.add_load(mesh.points, flow.on_walls(), one);
  by_nodes.add_load(mesh.points, flow.on_walls(), other);
  CHECK(one.norm() > 1e-3);
  CHECK((one - other).norm() < 1e-13 * one.norm());
}

TEST_CASE("beyond the sections the load at rest is that of the pressure below and above") {
  const TetMesh mesh = duct();
  std::vector<std::int32_t> faces;  // as above: the left fold begins below the right one, which ends above it
  for (const auto& t : mesh.surface("airway").rowwise()) {
    const Vector3 middle = (mesh.points.row(t[0]) + mesh.points.row(t[1]) + mesh.points.row(t[2])).transpose() / 3;
    if (middle[0] > 0 ? middle[2] > levels[1] : middle[2] < levels[3])
      faces.insert(faces.end(), t.begin(), t.end());
  }
  const Faces part = Eigen::Map<const Faces>(faces.data(), static_cast<std::ptrdiff_t>(faces.size()) / 3, 3);
  Airflow::Options options = thesis();
  const Airflow at_rest(mesh, part, options);
  options.load_shape = Airflow::CurrentShape{};
  const Airflow by_nodes(mesh, part, options);
  for (const double above : {0.0, 300.0}) {
    const Vector pressure = Vector::LinSpaced(3, 800, above);  // at both ends what lies beyond
    Vector one = Vector::Zero(mesh.points.size()), other = one;
    at_rest.add_load(mesh.points, {800, pressure, above}, one);
    by_nodes.add_load(mesh.points, {800, pressure, above}, other);
    double under = 0, over = 0;  // of nodes beyond the sections
    for (const std::int32_t node : by_nodes.nodes()) {
      const double z = mesh.points(node, 2), load = other.segment<3>(3 * std::ptrdiff_t(node)).norm();
      if (z < levels[1] - 1e-9) under += load;
      if (z > levels[3] + 1e-9) over += load;
    }
    CHECK(under > 1e-2 * other.norm());
    CHECK((over > 1e-2 * other.norm()) == (above > 0));
    CHECK((one - other).norm() < 1e-13 * other.norm());
  }
}

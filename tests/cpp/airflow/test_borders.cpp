#include "../borders.hpp"
#include "plica/airflow/airflow.hpp"
#include "plica/airflow/traction.hpp"
#include "plica/mesh/larynx.hpp"

using namespace plica;
using borders::indices;
using borders::Longer;
using borders::refused;
using borders::sizes;

TEST_CASE("an airflow refuses vectors of other meshes and sections, whatever its areas and its load") {
  const TetMesh mesh = larynx_mesh(Larynx::thesis_coarse());
  const Faces& left = mesh.surface("airway_left");
  const Faces& right = mesh.surface("airway_right");
  Faces surface(left.rows() + right.rows(), left.cols());
  surface << left, right;
  for (const bool cut : {true, false})
    for (const bool current : {true, false}) {
      CAPTURE(cut);
      CAPTURE(current);
      Airflow::Options options;
      if (!cut) options.area = EllipticSections{};
      if (current) options.load_shape = Airflow::CurrentShape{};
      const Airflow air(mesh, surface, options);
      Points x = mesh.points;
      Vector pressure = Vector::Constant(air.sections().count(), 100.0), force = Vector::Zero(x.size()),
             areas = air.areas(x), widths = air.section_areas().widths(x);
      const auto load = [&] { air.add_load(x, {800, pressure}, force); };
      sizes("Airflow::add_load x", x, load);
      sizes("Airflow::add_load pressure", pressure, load);
      sizes("Airflow::add_load force", force, load);
      sizes("Airflow::nodal_pressure pressure", pressure, [&] { air.nodal_pressure({800, pressure}); });
      sizes("Airflow::evaluate areas", areas, [&] { air.evaluate(areas); });
      Vector velocity = Vector::Zero(3 * air.nodes().size());
      sizes("LoadPatterns::expansion velocity", velocity, [&] { air.load_patterns().expansion(velocity); });
      AirwayExpansion moving{0.0, Vector::Zero(areas.size()), 0.0};
      sizes("Airflow::evaluate moving", moving.sections,
            [&] { air.evaluate(areas, air.air(0.0), false, std::nullopt, &moving); });
      sizes("SectionAreas::areas widths", widths, [&] { air.section_areas().areas(widths); });
      x = mesh.points.topRows(3);
      refused("Airflow::areas x", [&] { air.areas(x); });
      CHECK_THROWS_AS(air.sections().widths(x), InvalidInput);
      std::ptrdiff_t width = 0;
      const std::ptrdiff_t beyond = air.section_areas().width_count();
      borders::numbers<std::ptrdiff_t>("terms", width, {-1, beyond}, [&] { air.section_areas().terms(width); });
      borders::numbers<std::ptrdiff_t>("spacing", width, {-1, beyond},
                                       [&] { air.section_areas().spacing(width); });
      borders::numbers<std::ptrdiff_t>("section_of", width, {-1, beyond},
                                       [&] { air.section_areas().section_of(width); });
    }
  indices("Airflow::Airflow surface", surface, [&] { Airflow(mesh, surface, {}); });
  TetMesh less = mesh;
  less.points = mesh.points.topRows(3);
  refused("Airflow::Airflow mesh", [&] { Airflow(less, surface, {}); });
  Airflow::Options thesis;
  thesis.model = Bernoulli{};
  const Airflow jumping(mesh, surface, thesis);
  const Vector open = jumping.areas(mesh.points);
  std::optional<int> separation = 0;
  for (const int wrong : {-1, static_cast<int>(open.size())})
    refused("Airflow::evaluate separation", [&] { jumping.evaluate(open, false, wrong); });
  CHECK_NOTHROW(jumping.evaluate(open, false, separation));
  indices("level_sections surface", surface, [&] { level_sections(mesh, surface); });
  int count = 10;
  borders::numbers("count", count, {1, 0, -3}, [&] { graded_sections(mesh, surface, count); });
  Triangles triangles = flat_triangles(surface);
  const Vector heights = Vector::Constant(1, 0.0);
  indices("cut_areas surface", triangles, [&] { cut_areas(mesh.points, triangles, heights); });
  indices("cut_area surface", triangles, [&] { cut_area(mesh.points, triangles, 0.0); });
  indices("load_patterns faces", surface, [&] { load_patterns(mesh.points, surface, heights, 0.0); });
  Vector none;
  CHECK_THROWS_AS(load_patterns(mesh.points, surface, none, 0.0), InvalidInput);
}

TEST_CASE("flows refuse areas that are none, and sections that are not there") {
  Vector areas = Vector::Constant(4, 1e-5), height = Vector::LinSpaced(4, 0, 1e-3), length = height.array() + 1e-2;
  const Vector none;
  CHECK_THROWS_AS(bernoulli_flow({}, 0.0, none, false), InvalidInput);
  std::int32_t separation = 0;
  borders::numbers<std::int32_t>("separation", separation, {-1, 4},
                                 [&] { bernoulli_flow({}, 0.0, areas, false, separation); });
  const auto slit = [&] { viscous_slit_flow({}, {}, {height, length}, areas); };
  sizes("viscous_slit_flow areas", areas, slit);
  sizes("viscous_slit_flow height", height, slit);
  sizes("viscous_slit_flow length", length, slit);
}

TEST_CASE("a face has three nodes or six, and a material point a weight a node") {
  for (const int nodes : {0, 1, 2, 4, 5}) {
    CAPTURE(nodes);
    CHECK_THROWS_AS(pressure_load(FaceVectors::Zero(nodes, 3), FaceValues::Zero(nodes)), InvalidInput);
  }
  CHECK_THROWS_AS(pressure_load(FaceVectors::Zero(6, 3), FaceValues::Zero(3)), InvalidInput);
  CHECK_THROWS_AS(pressure_load(FaceVectors::Zero(3, 3), FaceValues::Zero(6)), InvalidInput);
  MaterialPoint point{{0, 1}, {0.5, 0.5}};
  Points x = Points::Zero(2, 3);
  const auto at = [&] { point.at(x); };
  sizes("nodes", point.nodes, at);
  sizes("weights", point.weights, at);
  sizes("x", x, at, Longer::unread);
  indices("nodes", point.nodes, at);
}

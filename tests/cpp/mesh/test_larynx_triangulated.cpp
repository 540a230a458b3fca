#include <doctest/doctest.h>

#include <set>

#include "../approx.hpp"
#include "invariants.hpp"
#include "plica/core/error.hpp"
#include "plica/mesh/edges.hpp"
#include "plica/mesh/jacobian.hpp"
#include "plica/mesh/larynx.hpp"
#include "plica/tissue/element.hpp"

using namespace plica;

namespace {

std::vector<Larynx> presets() { return {Larynx::coarse(), Larynx::demo(), Larynx::fine(), Larynx::finest()}; }

/// Volume of the cells by the rule of the engine's elements, exact for quadratic ones; of those for which
/// `counts`.
template <class Counts>
double volume(const TetMesh& mesh, const Counts& counts) {
  Element element(mesh.order());
  double sum = 0;
  for (Eigen::Index e = 0; e < mesh.cell_count(); ++e) {
    if (!counts(e)) continue;
    element.place(mesh.points, mesh.cells.data() + e * mesh.cells.cols());
    sum += element.volume();
  }
  return sum;
}

double minor_at(const Larynx::Shape& shape, double z) {
  std::size_t k = 1;
  while (k + 1 < shape.sections.size() && shape.sections[k].z < z) ++k;
  const auto &a = shape.sections[k - 1], &b = shape.sections[k];
  return a.minor + (b.minor - a.minor) * (z - a.z) / (b.z - a.z);
}

/// Volume between the airway and what lies deeper by that thickness along the lines, at most `most` of them,
/// between the layers' ends: area between two polygons of 4000 corners at each of 400 heights.
double layer_volume(const Larynx::Shape& shape, double thickness, double most) {
  constexpr int heights = 400, corners = 4000;
  const double low = shape.sections[shape.layers_from_section].z, high = shape.sections[shape.layers_to_section].z;
  double sum = 0;
  for (int k = 0; k < heights; ++k) {
    const double minor = minor_at(shape, low + (k + 0.5) / heights * (high - low));
    const auto at = [&](int i, double deep) {
      const double angle = 2 * test::pi * i / corners, c = std::cos(angle), s = std::sin(angle);
      const Eigen::Vector2d inner(minor * c, shape.major * s), out(shape.radius * c, shape.radius * s);
      const double length = (out - inner).norm();
      return Eigen::Vector2d(inner + std::min(deep, most * length) / length * (out - inner));
    };
    for (int i = 0; i < corners; ++i)
      for (const double deep : {0.0, thickness}) {
        const Eigen::Vector2d p = at(i, deep), q = at(i + 1, deep);
        sum += (deep > 0 ? 0.5 : -0.5) * (p[0] * q[1] - p[1] * q[0]) * (high - low) / heights;
      }
  }
  return sum;
}

}  // namespace

TEST_CASE("the presets by purpose pass every check and have the stated unknowns and quality") {
  const std::array<Eigen::Index, 4> unknowns = {9864, 21720, 43440, 87984};  // of quadratic cells, the wall held
  std::size_t k = 0;
  for (const Larynx& larynx : presets()) {
    const TetMesh mesh = quadratic_larynx_mesh(larynx);
    CHECK_NOTHROW(check_mesh(mesh));
    CHECK_NOTHROW(check_mesh(larynx_mesh(larynx)));
    CHECK(3 * (mesh.node_count() - mesh.node_set("wall").size()) == unknowns[k++]);
    CHECK(test::worst_mean_ratio(mesh.points, mesh.cells) > (k == 1 ? 0.025 : 0.035));
  }
}

TEST_CASE("no cell's Jacobian is below a tenth of the straight cell's, at no point of the quadrature either") {
  for (const Larynx& larynx : presets()) {
    const TetMesh mesh = quadratic_larynx_mesh(larynx);
    CHECK(least_jacobian_ratios(mesh.points, mesh.cells).minCoeff() >= 0.1);
    const Vector straight = signed_volumes(mesh.points, mesh.cells);
    Element element(2);
    double least = 1;
    for (Eigen::Index e = 0; e < mesh.cell_count(); ++e) {
      element.place(mesh.points, mesh.cells.data() + e * 10);
      least = std::min(least, element.least_jacobian() / straight[e]);
    }
    CHECK(least > 0.1);
    CHECK(least < 0.9);  // there are curved cells
  }
}

TEST_CASE("the triangulated larynx is its own mirror image to the last bit, mid-side nodes and labels included") {
  const TetMesh mesh = quadratic_larynx_mesh(Larynx::coarse());
  const auto cells = test::as_set(mesh.cells);
  CHECK(static_cast<Eigen::Index>(cells.size()) == mesh.cell_count());
  for (const double sign_x : {-1.0, 1.0}) {
    const auto image = test::mirror_nodes(mesh.points, sign_x, -sign_x);
    REQUIRE(*std::min_element(image.begin(), image.end()) >= 0);
    CHECK((test::as_set(mesh.cells, image) == cells));
  }
  const auto image = test::mirror_nodes(mesh.points, -1, 1);
  CHECK((test::as_set(mesh.surface("airway_left"), image) == test::as_set(mesh.surface("airway_right"))));
  auto both = test::as_set(mesh.surface("airway_left"));
  both.merge(test::as_set(mesh.surface("airway_right")));
  CHECK((both == test::as_set(mesh.surface("airway"))));
  for (const int layer : {0, 1, 2}) {
    std::array<Eigen::Index, 3> count{};
    for (Eigen::Index e = 0; e < mesh.cell_count(); ++e) count[mesh.cell_side[e]] += mesh.cell_layer[e] == layer;
    CHECK(count[0] == 0);
    CHECK(count[1] == count[2]);
    CHECK(count[1] > 0);
  }
}

TEST_CASE(
    "airway nodes lie on the ellipses and wall nodes on the cylinder, mid-side nodes too; heights are matched") {
  const Larynx larynx = Larynx::fine();
  const TetMesh mesh = quadratic_larynx_mesh(larynx);
  const Faces& airway = mesh.surface("airway");
  const std::set<std::int32_t> nodes(airway.data(), airway.data() + airway.size());
  double off_ellipse = 0, off_wall = 0, straightened = 0;
  std::map<double, int> of_height;
  for (const auto node : nodes) {
    const Vector3 x = mesh.points.row(node);
    const double minor = minor_at(larynx.shape, x[2]);
    off_ellipse = std::max(off_ellipse, std::abs(std::hypot(x[0] / minor, x[1] / larynx.shape.major) - 1));
    ++of_height[x[2]];
  }
  for (const auto node : mesh.node_set("wall")) {
    const double off = std::abs(mesh.points.row(node).head(2).norm() / larynx.shape.radius - 1);
    off_wall = std::max(off_wall, off);
    straightened += off > 1e-15;
  }
  CHECK(off_ellipse < 1e-12);  // roundoff, magnified by the flat ellipse
  // Some sides of the wall at the tips, where the tissue is thin, are straighter than the arc: off by less than
  // the sagitta of a chord.
  CHECK(off_wall < 1 - std::cos(test::pi / 20));
  CHECK(straightened < 0.25 * static_cast<double>(mesh.node_set("wall").size()));
  for (const auto& [z, count] : of_height) CHECK((count == 40 || count == 20));  // of levels and between them
  for (const auto& section : larynx.shape.sections) CHECK(of_height.count(section.z) == 1);
}

TEST_CASE("only at the tips, where tissue is thin, are airway nodes of the presets off their ellipses") {
  for (const Larynx& larynx : presets()) {
    const TetMesh mesh = quadratic_larynx_mesh(larynx);
    const double tip = 0.9 * larynx.shape.major;
    double elsewhere = 0, most = 0;  // of half-axes, and m
    for (const auto node : mesh.surface("airway").reshaped()) {
      const Vector3 x = mesh.points.row(node);
      const double minor = minor_at(larynx.shape, x[2]);
      const double off = std::abs(std::hypot(x[0] / minor, x[1] / larynx.shape.major) - 1);
      if (std::abs(x[1]) < tip) elsewhere = std::max(elsewhere, off);
      most = std::max(most, off * minor);
    }
    CHECK(elsewhere < 1e-12);
    CHECK(most < 40e-6);
  }
}

TEST_CASE("curved sides fill the volume between ellipses and cylinder, and straight ones miss it by h^2") {
  double curved[2], straight[2];
  int k = 0;
  Larynx wide;
  wide.meshed = Larynx::Triangulated{1e-3, 0.6, 12};
  for (const Larynx& larynx : {wide, wide.refined(2)}) {
    const double exact = test::exact_volume(larynx.shape);
    const auto all = [](Eigen::Index) { return true; };
    curved[k] = std::abs(volume(quadratic_larynx_mesh(larynx), all) / exact - 1);
    straight[k++] = std::abs(volume(larynx_mesh(larynx), all) / exact - 1);
  }
  CHECK(curved[0] < 0.02 * straight[0]);
  CHECK(std::log2(straight[0] / straight[1]) == approx(2).epsilon(0.1));
  CHECK(std::log2(curved[0] / curved[1]) > 3);
}

TEST_CASE("cover and ligament have the volume of their thickness along the lines, between their sections only") {
  Larynx larynx = Larynx::fine();
  const double t = larynx.shape.layer_thickness;
  double l = t;
  SUBCASE("of one thickness") {}
  SUBCASE("of two") { larynx.shape.ligament_thickness = l = 1.5 * t; }
  const TetMesh mesh = quadratic_larynx_mesh(larynx);
  const double cover = layer_volume(larynx.shape, t, 0.3), both = layer_volume(larynx.shape, t + l, 0.6);
  const auto of = [&](int layer) {
    return volume(mesh, [&](Eigen::Index e) { return mesh.cell_layer[e] == layer; });
  };
  CHECK(of(2) == approx(cover).epsilon(0.03));
  CHECK(of(1) == approx(both - cover).epsilon(0.03));
  const double low = larynx.shape.sections[4].z, high = larynx.shape.sections[7].z;
  bool inside = true;
  for (Eigen::Index e = 0; e < mesh.cell_count(); ++e)
    for (int k = 0; k < 4 && mesh.cell_layer[e] > 0; ++k) {
      const double z = mesh.points(mesh.cells(e, k), 2);
      inside &= low <= z && z <= high;
    }
  CHECK(inside);
}

TEST_CASE("where the glottis is narrow no edge runs from behind its tip to the airway's next line") {
  for (const int around : {12, 16}) {  // the tip on an odd and on an even line
    Larynx larynx = Larynx::coarse();
    std::get<Larynx::Triangulated>(larynx.meshed).around = around;
    for (Larynx::Section& section : larynx.shape.sections)
      if (section.minor < 0.05e-2) section.minor = 0.01e-2;
    const TetMesh mesh = larynx_mesh(larynx);
    std::set<std::int32_t> airway;
    const Faces& faces = mesh.surface("airway");
    airway.insert(faces.data(), faces.data() + faces.size());
    const auto narrow = [&](std::int32_t node) {  // within the sections that are
      return mesh.points(node, 2) > larynx.shape.sections[5].z &&
             mesh.points(node, 2) < larynx.shape.sections[6].z;
    };
    const auto on_tip_plane = [&](std::int32_t node) { return mesh.points(node, 0) == 0; };
    int from_tip = 0, from_behind = 0;
    for (const auto& [a, b] : unique_edges(mesh.cells))
      for (const auto& [at_tip, next] : {std::pair{a, b}, std::pair{b, a}}) {
        if (!on_tip_plane(at_tip) || on_tip_plane(next) || !narrow(at_tip) || !narrow(next)) continue;
        from_tip += airway.count(at_tip) && !airway.count(next);
        from_behind += !airway.count(at_tip) && airway.count(next);
      }
    CHECK(from_tip > 0);
    CHECK(from_behind == 0);
  }
}

TEST_CASE("tip_cut says how wide a glottis may be whose cells are cut from its tip") {
  int most = 0;
  for (const int around : {12, 16})  // of one of them the turns of the cuts make none flat
    for (const double tip_cut : {0.1, 1.0}) {
      Larynx larynx = Larynx::coarse();
      larynx.meshed = Larynx::Triangulated{0.35e-3, 0.7, around, tip_cut};
      const TetMesh mesh = larynx_mesh(larynx);
      std::set<std::int32_t> airway;
      const Faces& faces = mesh.surface("airway");
      airway.insert(faces.data(), faces.data() + faces.size());
      int flat = 0;
      for (const auto& [a, b] : unique_edges(mesh.cells))
        for (const auto& [behind, next] : {std::pair{a, b}, std::pair{b, a}}) {
          const double x = std::abs(mesh.points(next, 0)), y = std::abs(mesh.points(next, 1));
          flat += mesh.points(behind, 0) == 0 && !airway.count(behind) && airway.count(next) && x > 0 &&
                  x < larynx.shape.major - y;
        }
      if (tip_cut == 1.0) CHECK(flat == 0);
      if (tip_cut == 0.1) most = std::max(most, flat);
    }
  CHECK(most > 0);
}

TEST_CASE("layers along the normal are as thick as stated across the surface, in the plane y = 0") {
  Larynx larynx = Larynx::fine();
  larynx.shape.layers_along = Larynx::LayersAlong::normal;
  const double cover = larynx.shape.layer_thickness;
  double ligament = cover;
  SUBCASE("of one thickness") {}
  SUBCASE("of two") { larynx.shape.ligament_thickness = ligament = 0.6 * cover; }
  const TetMesh mesh = larynx_mesh(larynx);
  const auto& s = larynx.shape.sections;
  const auto to_profile = [&](double x, double z) {  // to the lines of the three pieces the layers lie behind
    double least = 1;
    for (int k = 4; k < 7; ++k) {
      const Eigen::Vector2d a(s[k].minor, s[k].z), along = Eigen::Vector2d(s[k + 1].minor, s[k + 1].z) - a;
      const Eigen::Vector2d p = Eigen::Vector2d(x, z) - a;
      least = std::min(least, (p[0] * along[1] - p[1] * along[0]) / along.norm());
    }
    return least;
  };
  int found = 0;
  for (const int layer : {1, 2}) {  // what two layers share at y = 0, off the airway
    std::map<std::int32_t, std::set<int>> layers;
    for (Eigen::Index e = 0; e < mesh.cell_count(); ++e)
      for (int k = 0; k < 4; ++k) layers[mesh.cells(e, k)].insert(mesh.cell_layer[e]);
    for (const auto& [node, of] : layers) {
      const Vector3 x = mesh.points.row(node);
      if (x[1] != 0 || x[0] < 0 || x[2] == s[4].z || x[2] == s[7].z) continue;
      if (!of.count(layer) || !of.count(layer == 2 ? 1 : 0)) continue;
      CHECK(to_profile(x[0], x[2]) == approx(layer == 2 ? cover : cover + ligament));
      ++found;
    }
  }
  CHECK(found > 6);
  larynx.shape.ligament_thickness.reset();
  larynx.shape.layer_thickness = 0.3e-2;
  CHECK_THROWS_WITH_AS(larynx_mesh(larynx), doctest::Contains("along the normal"), InvalidInput);
}

TEST_CASE("layers measured level are the same in levels and along the normal where the surface is vertical") {
  Larynx level = Larynx::thesis_coarse(), normal = level;
  normal.shape.layers_along = Larynx::LayersAlong::normal;
  const TetMesh a = larynx_mesh(level), b = larynx_mesh(normal);
  double upright = 0, sloping = 0;
  for (Eigen::Index n = 0; n < a.node_count(); ++n) {
    const double z = a.points(n, 2), moved = (a.points.row(n) - b.points.row(n)).norm();
    (z > -0.25e-2 && z < -0.1e-2 ? upright : sloping) =
        std::max(moved, z > -0.25e-2 && z < -0.1e-2 ? upright : sloping);
  }
  CHECK(upright < 1e-12);
  CHECK(sloping > 1e-5);
}

TEST_CASE("a refined larynx has about the factor cubed times the cells") {
  const auto cells = [](const Larynx& larynx) { return static_cast<double>(larynx_mesh(larynx).cell_count()); };
  const double base = cells(Larynx::demo());
  CHECK(cells(Larynx::demo().refined(1)) == base);
  CHECK(cells(Larynx::demo().refined(1.26)) / base == approx(2).epsilon(0.3));
  CHECK(cells(Larynx::demo().refined(2)) / base == approx(8).epsilon(0.3));
}

TEST_CASE("sizes out of range are refused by name") {
  const auto refusal = [](Larynx::Triangulated how) {
    Larynx larynx;
    larynx.meshed = how;
    try {
      larynx_mesh(larynx);
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  CHECK(refusal({}) == "accepted");
  CHECK(refusal({0, 0.3, 12}) == "Larynx: size = 0 m; must be > 0.");
  CHECK(refusal({1e-3, -1, 12}) == "Larynx: growth = -1; must be >= 0.");
  CHECK(refusal({1e-3, 0.3, 10}).find("around = 10; must be a multiple of 4") != std::string::npos);
  CHECK(refusal({1e-6, 0.3, 12}).find("points of the half section by size = 1e-06 m") != std::string::npos);
  CHECK(refusal({0.05e-3, 0, 12}).find("growth = 0") != std::string::npos);  // its body alone has too many
  CHECK(refusal({2e-3, 0.4, 16}).find("Take a smaller size or more lines around") != std::string::npos);
  CHECK_THROWS_AS(Larynx{}.refined(0), InvalidInput);
}

TEST_CASE("whatever the radius, what is neither airway nor end is wall") {
  for (const double radius : {8e-3, 9e-3, 9.5e-3, 1e-2, 1.1e-2}) {
    CAPTURE(radius);
    Larynx larynx = Larynx::coarse();
    larynx.shape.radius = radius;
    const TetMesh mesh = larynx_mesh(larynx);
    std::set<std::int32_t> named;
    for (const char* set : {"wall", "ends"})
      for (const auto node : mesh.node_set(set)) named.insert(node);
    for (const auto node : mesh.surface("airway").reshaped()) named.insert(node);
    const Boundary hull = boundary_of(mesh.cells);
    int missing = 0;
    for (const auto node : hull.faces.reshaped()) missing += named.count(node) == 0;
    CHECK(missing == 0);
  }
}

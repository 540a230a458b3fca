#include <doctest/doctest.h>

#include <limits>
#include <set>

#include "../approx.hpp"
#include "invariants.hpp"
#include "plica/core/error.hpp"
#include "plica/mesh/larynx.hpp"

using namespace plica;

namespace {

Larynx::Levels& in_levels(Larynx& larynx) { return std::get<Larynx::Levels>(larynx.meshed); }

}  // namespace

TEST_CASE("the presets have the stated numbers of tetrahedra and nodes, all positive") {
  struct {
    Larynx larynx = Larynx::thesis_coarse();
    Eigen::Index cells, nodes;
    double quality;  // least mean ratio, of the tall thin cells at the ends
  } const presets[] = {{Larynx::thesis_coarse(), 4032, 900, 0.007},
                       {Larynx::thesis_demo(), 7296, 1600, 0.007},
                       {Larynx::thesis_medium(), 19440, 4032, 0.016},
                       {Larynx::thesis(), 55080, 11232, 0.025}};
  for (const auto& preset : presets) {
    const TetMesh mesh = larynx_mesh(preset.larynx);
    CHECK(mesh.cell_count() == preset.cells);
    CHECK(mesh.node_count() == preset.nodes);
    CHECK(signed_volumes(mesh.points, mesh.cells).minCoeff() > 0);
    CHECK(test::worst_mean_ratio(mesh.points, mesh.cells) > preset.quality);
  }
}

TEST_CASE("the larynx is conforming and its boundary closed, in levels and triangulated") {
  for (const Larynx& larynx : {Larynx::thesis_coarse(), Larynx::coarse()}) {
    const TetMesh mesh = larynx_mesh(larynx);
    const Boundary hull = boundary_of(mesh.cells);
    Eigen::Index single = 0;
    bool conforming = true;
    for (const auto& [face, uses] : test::face_uses(mesh.cells)) {
      conforming &= uses <= 2;
      single += uses == 1;
    }
    CHECK(conforming);
    // Airway and wall: two triangles to a quad; top and bottom likewise.
    if (std::holds_alternative<Larynx::Levels>(larynx.meshed)) CHECK(single == 2 * 12 * (14 + 14 + 4 + 4));
    CHECK(single == hull.faces.rows());
    CHECK(test::area_vector(mesh.points, hull.faces).norm() < 1e-15);  // roundoff of 1e-3 m^2
    CHECK(test::enclosed_volume(mesh.points, hull.faces) ==
          approx(signed_volumes(mesh.points, mesh.cells).sum()).epsilon(1e-12));
  }
}

TEST_CASE("the airway volume tends to that of the ellipses, and the wall's is that of its polygon") {
  double error[3];
  for (const int factor : {1, 2, 4}) {
    Larynx larynx = Larynx::thesis();
    in_levels(larynx).around = 12 * factor;
    const TetMesh mesh = larynx_mesh(larynx);
    const double height = larynx.shape.sections.back().z - larynx.shape.sections.front().z;
    const double polygon = 6 * factor * std::pow(larynx.shape.radius, 2) * std::sin(2 * test::pi / (12 * factor));
    const double airway = height * polygon - signed_volumes(mesh.points, mesh.cells).sum();
    const double exact = height * test::pi * std::pow(larynx.shape.radius, 2) - test::exact_volume(larynx.shape);
    error[factor / 2] = 1 - airway / exact;
  }
  CHECK(error[0] > 0);  // chords lie inside the ellipse
  CHECK(error[0] < 0.1);
  // Between the order 2 of a smooth arc and the 3/2 of the tip, where the ellipse is a root of the parameter.
  const double first = std::log2(error[0] / error[1]), second = std::log2(error[1] / error[2]);
  CHECK(first < 2);
  CHECK(second < first);
  CHECK(second > 1.5);
}

TEST_CASE("the mesh is its own mirror image to the last bit, in x and in y") {
  const TetMesh mesh = larynx_mesh(Larynx::thesis_coarse());
  const auto cells = test::as_set(mesh.cells);
  CHECK(static_cast<Eigen::Index>(cells.size()) == mesh.cell_count());
  for (const double sign_x : {-1.0, 1.0}) {
    const auto image = test::mirror_nodes(mesh.points, sign_x, -sign_x);
    REQUIRE(*std::min_element(image.begin(), image.end()) >= 0);
    CHECK((test::as_set(mesh.cells, image) == cells));
  }
}

TEST_CASE("each triangle of the left airway faces its mirror image on the right") {
  const TetMesh mesh = larynx_mesh(Larynx::thesis_coarse());
  const auto image = test::mirror_nodes(mesh.points, -1, 1);
  const Faces &left = mesh.surface("airway_left"), &right = mesh.surface("airway_right");
  CHECK(left.rows() == 12 * 14);
  CHECK((test::as_set(left, image) == test::as_set(right)));
  auto both = test::as_set(left);
  both.merge(test::as_set(right));
  CHECK((both == test::as_set(mesh.surface("airway"))));
}

TEST_CASE("the airway surfaces point into the air") {
  const TetMesh mesh = larynx_mesh(Larynx::thesis_coarse());
  for (const auto& [name, sign] : {std::pair<std::string, double>{"airway_left", 1}, {"airway_right", -1}}) {
    const Faces& faces = mesh.surface(name);
    double least = 1;
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
      const Vector3 area = test::area_vector(mesh.points, faces(f, 0), faces(f, 1), faces(f, 2));
      least = std::min(least, sign * area[0] / area.norm());
    }
    CHECK(least > 0);
  }
}

TEST_CASE("airway nodes lie on the ellipses, wall nodes on the cylinder, lines at y = 0 and at the tips") {
  const Larynx larynx = Larynx::thesis();
  const TetMesh mesh = larynx_mesh(larynx);
  double off_ellipse = 0, off_wall = 0;
  std::set<double> heights, right, tip;
  const Faces& airway = mesh.surface("airway");
  const std::set<std::int32_t> nodes(airway.data(), airway.data() + airway.size());
  for (const auto node : nodes) {
    const Vector3 x = mesh.points.row(node);
    std::size_t k = 1;
    while (k + 1 < larynx.shape.sections.size() && larynx.shape.sections[k].z < x[2]) ++k;
    const auto &a = larynx.shape.sections[k - 1], &b = larynx.shape.sections[k];
    const double minor = a.minor + (b.minor - a.minor) * (x[2] - a.z) / (b.z - a.z);
    off_ellipse = std::max(off_ellipse, std::abs(std::hypot(x[0] / minor, x[1] / larynx.shape.major) - 1));
    heights.insert(x[2]);
    if (x[1] == 0 && x[0] > 0) right.insert(x[2]);
    if (x[0] == 0 && x[1] == larynx.shape.major) tip.insert(x[2]);
  }
  for (const auto node : mesh.node_set("wall"))
    off_wall = std::max(off_wall, std::abs(mesh.points.row(node).head(2).norm() / larynx.shape.radius - 1));
  CHECK(off_ellipse < 1e-12);  // roundoff, magnified by the flat ellipse
  CHECK(off_wall < 1e-15);
  CHECK(heights.size() == 52);  // S0 ... S51
  CHECK((right == heights));
  CHECK((tip == heights));
  for (const auto& section : larynx.shape.sections) CHECK(heights.count(section.z) == 1);
  CHECK(mesh.node_set("wall").size() == 52 * 36);
  CHECK(mesh.node_set("ends").size() == 2 * 6 * 36);
}

TEST_CASE("cover and ligament fill their thickness between S17 and S27 and nothing elsewhere") {
  const Larynx larynx = Larynx::thesis();
  const TetMesh mesh = larynx_mesh(larynx);
  const Vector volume = signed_volumes(mesh.points, mesh.cells);
  double layer[3] = {0, 0, 0}, sides[3] = {0, 0, 0}, area = 0;
  bool inside = true, sided = true;
  const double low = larynx.shape.sections[4].z, high = larynx.shape.sections[7].z;
  for (Eigen::Index e = 0; e < mesh.cell_count(); ++e) {
    layer[mesh.cell_layer[e]] += volume[e];
    sides[mesh.cell_side[e]] += volume[e];
    Vector3 centre = Vector3::Zero();
    for (int k = 0; k < 4; ++k) centre += mesh.points.row(mesh.cells(e, k)).transpose() / 4;
    if (mesh.cell_layer[e] > 0) inside &= low < centre[2] && centre[2] < high;
    sided &= mesh.cell_side[e] == static_cast<int>(centre[0] < 0 ? Side::left : Side::right);
  }
  const Faces& airway = mesh.surface("airway");
  for (Eigen::Index f = 0; f < airway.rows(); ++f) {
    const double z =
        (mesh.points(airway(f, 0), 2) + mesh.points(airway(f, 1), 2) + mesh.points(airway(f, 2), 2)) / 3;
    if (low < z && z < high)
      area += test::area_vector(mesh.points, airway(f, 0), airway(f, 1), airway(f, 2)).norm();
  }
  CHECK(inside);
  CHECK(sided);
  // Thickness is measured along lines that lean away from the normal, and is less at the tips.
  CHECK(layer[2] < larynx.shape.layer_thickness * area);
  CHECK(layer[2] > 0.85 * larynx.shape.layer_thickness * area);
  CHECK(layer[1] > layer[2]);  // the lines diverge
  CHECK(layer[1] < 1.2 * layer[2]);
  CHECK(sides[1] == approx(sides[2]).epsilon(1e-12));
}

TEST_CASE("the long ends are graded so that heights grow away from the glottis by at most three") {
  Larynx larynx = Larynx::thesis();
  in_levels(larynx).levels.front() = 9;
  in_levels(larynx).levels[1] = 11;  // 0.03 cm, finer than 1.22 cm / 9
  const TetMesh mesh = larynx_mesh(larynx);
  std::set<double> distinct;
  for (Eigen::Index n = 0; n < mesh.node_count(); ++n) distinct.insert(mesh.points(n, 2));
  const std::vector<double> z(distinct.begin(), distinct.end());
  const auto height = [&](std::size_t k) { return z[k + 1] - z[k]; };
  CHECK(height(8) == approx(height(9)).epsilon(1e-9));  // bisection ends at roundoff
  const double ratio = height(7) / height(8);
  CHECK(ratio > 1.1);
  CHECK(ratio < 3);
  for (std::size_t k = 0; k < 7; ++k) CHECK(height(k) / height(k + 1) == approx(ratio).epsilon(1e-9));
  const std::size_t last = z.size() - 2;
  CHECK(height(last - 7) == approx(height(last - 8)).epsilon(1e-9));
  for (std::size_t k = last - 7; k < last; ++k) CHECK(height(k + 1) > height(k));
}

TEST_CASE("more rings in a layer change neither its volume nor the airway") {
  Larynx larynx = Larynx::thesis_coarse();
  const TetMesh plain = larynx_mesh(larynx);
  in_levels(larynx).cover_rings = 2;
  in_levels(larynx).ligament_rings = 3;
  const TetMesh fine = larynx_mesh(larynx);
  CHECK(fine.surface("airway").rows() == plain.surface("airway").rows());
  const auto layer = [](const TetMesh& mesh, int which) {
    return (mesh.cell_layer.array() == which).select(signed_volumes(mesh.points, mesh.cells).array(), 0.0).sum();
  };
  for (const int which : {1, 2})  // ring faces are not flat: the cut of the quads costs a little volume
    CHECK(layer(fine, which) == approx(layer(plain, which)).epsilon(0.01));
}

TEST_CASE("lines too dense for the levels of the long ends are refused with the height and the remedy") {
  Larynx larynx = Larynx::thesis_coarse();
  in_levels(larynx).around = 48;  // the lines lean by an angle that turns within one tall level
  CHECK_THROWS_AS(larynx_mesh(larynx), InvalidInput);
  in_levels(larynx).levels.back() = 3;
  CHECK_NOTHROW(larynx_mesh(larynx));
}

TEST_CASE("options out of range are refused by name") {
  const auto refusal = [](void (*change)(Larynx&)) {
    Larynx larynx = Larynx::thesis_coarse();
    change(larynx);
    try {
      larynx_mesh(larynx);
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  CHECK(refusal([](Larynx&) {}) == "accepted");
  CHECK(refusal([](Larynx& l) { in_levels(l).around = 10; }) ==
        "Larynx: around = 10; must be a multiple of 4. Lines at y = 0 and at both tips need it.");
  CHECK(refusal([](Larynx& l) { in_levels(l).around = 4; }) == "Larynx: around = 4; must be >= 8.");
  CHECK(refusal([](Larynx& l) { l.shape.major = 0.9e-2; }).find("major = 0.009 m; must be < radius") !=
        std::string::npos);
  CHECK(refusal([](Larynx& l) { l.shape.sections[7].minor = -0.05e-2; }) ==
        "Larynx: sections[7].minor = -0.0005 m; must be > 0.");
  CHECK(refusal([](Larynx& l) { l.shape.sections[2].z = -1; }).find("sections[2].z = -1 m; must be > -0.0078 m") !=
        std::string::npos);
  CHECK(refusal([](Larynx& l) { in_levels(l).levels.pop_back(); }).find("number of levels = 9; must be 10") !=
        std::string::npos);
  CHECK(refusal([](Larynx& l) { in_levels(l).levels[3] = 0; }) == "Larynx: levels[3] = 0; must be >= 1.");
  CHECK(refusal([](Larynx& l) { l.shape.layers_to_section = 4; }) ==
        "Larynx: layers_to_section = 4; must be >= 5.");
  CHECK(refusal([](Larynx& l) { l.shape.layers_to_section = 11; }).find("must be <= 10") != std::string::npos);
  CHECK(refusal([](Larynx& l) { l.shape.layer_thickness = 0; }) == "Larynx: layer_thickness = 0 m; must be > 0.");
  CHECK(refusal([](Larynx& l) { l.shape.ligament_thickness = -1e-3; }) ==
        "Larynx: ligament_thickness = -0.001 m; must be > 0.");
  CHECK(refusal([](Larynx& l) { in_levels(l).body_rings = 0; }) == "Larynx: body_rings = 0; must be >= 1.");
  CHECK(refusal([](Larynx& l) {
          l.meshed = Larynx::Triangulated{0.35e-3, 0.7, 12, -0.5};
        }) == "Larynx: tip_cut = -0.5; must be >= 0.");
  CHECK(refusal([](Larynx& l) {
          l.meshed = Larynx::Triangulated{0.35e-3, 0.7, 12, std::numeric_limits<double>::infinity()};
        }) == "Larynx: tip_cut = inf; must be >= 0 and finite.");
  CHECK(refusal([](Larynx& l) {
          l.meshed = Larynx::Triangulated{0.35e-3, std::numeric_limits<double>::quiet_NaN(), 12, 0.1};
        }) == "Larynx: growth = nan; must be >= 0 and finite.");
}

TEST_CASE("a larynx of more nodes than can be numbered is refused before anything overflows") {
  Larynx larynx = Larynx::thesis_coarse();
  in_levels(larynx).around = 400000000;
  CHECK_THROWS_WITH_AS(larynx.validate(), doctest::Contains("must be <= 5e7"), InvalidInput);
  larynx = Larynx::thesis_coarse();
  in_levels(larynx).levels.front() = in_levels(larynx).levels.back() = 2147483647;  // their sum is beyond 32 bits
  CHECK_THROWS_WITH_AS(larynx.validate(), doctest::Contains("Fewer levels, lines or rings"), InvalidInput);
  larynx = Larynx::thesis_coarse();
  in_levels(larynx).cover_rings = in_levels(larynx).ligament_rings = 2147483647;
  CHECK_THROWS_AS(larynx.validate(), InvalidInput);
  CHECK_THROWS_WITH_AS(Larynx::thesis_coarse().refined(2000000000), doctest::Contains("Larynx::refined: factor"),
                       InvalidInput);
}

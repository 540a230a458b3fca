#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include "plica/core/error.hpp"
#include "plica/mesh/block.hpp"
#include "plica/mesh/larynx.hpp"

using namespace plica;

namespace {

TetMesh cube() {
  Block block;
  block.divisions = {2, 2, 2};
  return block_mesh(block);
}

/// The message with which check refuses the mesh after the damage; the mesh itself must pass.
std::string refusal(TetMesh mesh, const std::function<void(TetMesh&)>& damage) {
  check_mesh(mesh);
  damage(mesh);
  try {
    check_mesh(mesh);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

#define CHECK_SAYS(text, part) CHECK_MESSAGE((text).find(part) != std::string::npos, (text))

}  // namespace

TEST_CASE("sound meshes of both orders are accepted, and bodies that touch") {
  CHECK_NOTHROW(check_mesh(cube()));
  CHECK_NOTHROW(check_mesh(to_quadratic(cube())));
  CHECK_NOTHROW(check_mesh(to_quadratic(larynx_mesh(Larynx::thesis_coarse()))));
  CHECK_NOTHROW(check_mesh(combine_meshes(cube(), cube(), "a.", "b.")));  // every node coincides with another
}

TEST_CASE("wrong shapes and numbers are refused") {
  CHECK_SAYS(refusal(cube(), [](TetMesh& m) { m.cells.resize(0, 4); }), "there is no cell");
  CHECK_SAYS(refusal(cube(), [](TetMesh& m) { m.cells.conservativeResize(m.cells.rows(), 3); }),
             "nodes per cell = 3; must be 4 or 10");
  CHECK_SAYS(refusal(cube(), [](TetMesh& m) { m.cell_layer.resize(5); }), "size of cell_layer = 5; must be 48");
  CHECK_SAYS(refusal(cube(), [](TetMesh& m) { m.cell_side.resize(5); }), "size of cell_side = 5; must be 48");
  CHECK_SAYS(refusal(cube(), [](TetMesh& m) { m.points(7, 1) = std::nan(""); }), "node 7 is at (0.5, nan, 0) m");
}

TEST_CASE("a mesh without labels has one layer and no side") {
  TetMesh mesh = cube();
  const TetMesh whole = mesh;
  mesh.cell_layer.resize(0);
  mesh.cell_side.resize(0);
  mesh.layer_names.clear();
  CHECK_NOTHROW(check_mesh(mesh));
  CHECK_NOTHROW(check_mesh(to_quadratic(mesh)));
  const TetMesh found = labelled(mesh);
  CHECK(found.layer_names == std::vector<std::string>{"body"});
  CHECK(found.cell_layer == Indices::Zero(48));
  CHECK(found.cell_side == Indices::Zero(48));
  CHECK(combine_meshes(mesh, whole, "a.", "b.").cell_layer == combine_meshes(whole, whole, "a.", "b.").cell_layer);
  CHECK(combine_meshes(whole, mesh, "a.", "b.").layer_names == std::vector<std::string>{"a.body", "b.body"});

  mesh.layer_names = {"cover"};
  CHECK_NOTHROW(check_mesh(mesh));
  CHECK(labelled(mesh).layer_names == std::vector<std::string>{"cover"});
  mesh.layer_names = {"body", "cover"};
  CHECK_SAYS(refusal(whole, [&](TetMesh& m) { m = labelled(mesh); }), "size of cell_layer = 0; must be 48");
}

TEST_CASE("a mesh too far away for its edges is refused where it lies, and one that is near is not") {
  const auto moved = [](double far) { return [far](TetMesh& m) { m.points.col(1).array() -= far; }; };
  CHECK(refusal(cube(), moved(1e9)) == "accepted");  // edges of 0.5 m: up to 2.25e9 m
  CHECK_SAYS(refusal(cube(), moved(3e9)),
             "coordinate y of node 0 = -3e+09 m; must be within 2.2518e+09 m of 0, as the shortest edge is 0.5 m");
}

TEST_CASE("coordinates are counted from 0 near it, and from the middle of a mesh further away than it is wide") {
  const Points near = cube().points.rowwise() + Eigen::RowVector3d(1.2, -1.2, 0);
  CHECK(origin_near(near) == Vector3::Zero());
  const Points far = cube().points.rowwise() + Eigen::RowVector3d(1.2, -50, 1e6);
  CHECK(origin_near(far) == Vector3(0, -49.5, 1e6 + 0.5));
}

TEST_CASE("indices out of range are refused") {
  CHECK_SAYS(refusal(cube(), [](TetMesh& m) { m.cells(3, 2) = 27; }), "cell 3 names node 27; must be in [0, 27)");
  CHECK_SAYS(refusal(cube(), [](TetMesh& m) { m.cells(3, 2) = -1; }), "cell 3 names node -1");
  CHECK_SAYS(refusal(cube(), [](TetMesh& m) { m.cell_layer[9] = 1; }), "has layer 1; must be in [0, 1)");
  CHECK_SAYS(refusal(cube(), [](TetMesh& m) { m.cell_side[9] = 3; }), "has side 3");
  CHECK_SAYS(refusal(cube(), [](TetMesh& m) { m.surfaces["x_min"](1, 0) = 99; }),
             "surface \"x_min\": face 1 names node 99");
  CHECK_SAYS(refusal(cube(), [](TetMesh& m) { m.node_sets["x_min"][2] = 27; }),
             "node set \"x_min\" names node 27; must be in [0, 27)");
}

TEST_CASE("a node without a cell is refused with its place") {
  CHECK_SAYS(refusal(cube(),
                     [](TetMesh& m) {
                       m.points.conservativeResize(28, 3);
                       m.points.row(27) << 5, 6, 7;
                     }),
             "node 27 at (5, 6, 7) m belongs to no cell");
}

TEST_CASE("inverted, flat and folded cells are refused with their places") {
  const auto inverted = refusal(cube(), [](TetMesh& m) { std::swap(m.cells(5, 0), m.cells(5, 1)); });
  CHECK_SAYS(inverted, "cell 5 at (");
  CHECK_SAYS(inverted, "has volume -0.0208333 m^3; must be > 0. It is inverted");
  const auto flat = refusal(cube(), [](TetMesh& m) {
    m.points.row(m.cells(0, 3)) = (m.points.row(m.cells(0, 0)) + m.points.row(m.cells(0, 1))) / 2;
  });
  CHECK_SAYS(flat, "It is flat");
  const auto folded = refusal(to_quadratic(cube()), [](TetMesh& m) {
    const auto a = m.cells(0, 0), b = m.cells(0, 1);
    m.points.row(m.cells(0, 4)) = 0.9 * m.points.row(a) + 0.1 * m.points.row(b);  // beyond a quarter it folds
  });
  CHECK_SAYS(folded, "folds over at its node");
  const auto gmsh = refusal(to_quadratic(cube()), [](TetMesh& m) { m.cells.col(8).swap(m.cells.col(9)); });
  CHECK_SAYS(gmsh, "Gmsh exchanges the last two");
}

TEST_CASE("folded cells are counted, also those whose corners are in order") {
  const TetMesh linear = cube(), quadratic = to_quadratic(cube());
  CHECK(folded_cells(linear.points, linear.cells) == 0);
  CHECK(folded_cells(quadratic.points, quadratic.cells) == 0);
  Points x = linear.points;
  x.col(2) *= -1;
  CHECK(folded_cells(x, linear.cells) == linear.cell_count());
  const auto a = quadratic.cells(0, 0), b = quadratic.cells(0, 1), middle = quadratic.cells(0, 4);
  const auto around = (quadratic.cells.array() == middle).rowwise().any().count();  // the cells at that edge
  for (const double part : {0.1, 0.9}) {  // near either end it folds the cells there
    x = quadratic.points;
    x.row(middle) = (1 - part) * x.row(a) + part * x.row(b);
    CHECK(signed_volumes(x, quadratic.cells).minCoeff() > 0);
    CHECK(folded_cells(x, quadratic.cells) == around);
  }
}

TEST_CASE("a mid-side node moved by less than a quarter of its edge is accepted") {
  TetMesh mesh = to_quadratic(cube());
  mesh.points.row(mesh.cells(0, 4)) =
      0.7 * mesh.points.row(mesh.cells(0, 0)) + 0.3 * mesh.points.row(mesh.cells(0, 1));
  CHECK_NOTHROW(check_mesh(mesh));
}

TEST_CASE("duplicate and overlapping cells are refused") {
  const auto append = [](TetMesh& m, const Eigen::RowVector4i& corners) {
    const auto last = m.cell_count();
    m.cells.conservativeResize(last + 1, 4);
    m.cells.row(last) = corners;
    m.cell_layer.conservativeResize(last + 1);
    m.cell_side.conservativeResize(last + 1);
    m.cell_layer[last] = m.cell_side[last] = 0;
  };
  CHECK_SAYS(refusal(cube(), [&](TetMesh& m) { append(m, m.cells.row(4)); }), "has the corners of cell 4");
  CHECK_SAYS(refusal(cube(),
                     [&](TetMesh& m) {
                       // The same inner face with a farther apex is a third cell on it.
                       for (Eigen::Index e = 1; e < m.cell_count(); ++e)
                         for (std::int32_t apex = 26; apex > 0; --apex) {
                           Eigen::RowVector4i corners = m.cells.row(0);
                           if ((corners.array() == apex).any()) continue;
                           corners[0] = apex;
                           Cells one = corners;
                           if (signed_volumes(m.points, one)[0] > 1e-3) return append(m, corners);
                         }
                     }),
             "shares a face with two other cells");
}

TEST_CASE("an edge with two mid-side nodes is refused") {
  CHECK_SAYS(refusal(to_quadratic(cube()),
                     [](TetMesh& m) {
                       const auto shared = m.cells(0, 4);
                       const auto fresh = static_cast<std::int32_t>(m.node_count());
                       m.points.conservativeResize(fresh + 1, 3);
                       m.points.row(fresh) = m.points.row(shared);
                       m.cells(0, 4) = fresh;
                     }),
             "Every edge has one mid-side node of its own");
}

TEST_CASE("surfaces that are not outward boundary faces are refused") {
  CHECK_SAYS(refusal(cube(), [](TetMesh& m) { m.surfaces["none"].resize(0, 3); }), "surface \"none\" is empty");
  CHECK_SAYS(refusal(cube(), [](TetMesh& m) { m.surfaces["wide"] = Faces::Zero(1, 6); }),
             "surface \"wide\": nodes per face = 6; must be 3");
  CHECK_SAYS(refusal(cube(),
                     [](TetMesh& m) {
                       Faces inner(1, 3);  // a face of cell 0 with the centre of the cube, node 13
                       for (int omitted = 0; omitted < 4; ++omitted) {
                         bool centre = false;
                         for (int k = 0, to = 0; k < 4; ++k)
                           if (k != omitted) {
                             centre |= m.cells(0, k) == 13;
                             inner(0, to++) = m.cells(0, k);
                           }
                         if (centre) m.surfaces["inner"] = inner;
                       }
                     }),
             "surface \"inner\": face 0 with node");
  const auto inward =
      refusal(cube(), [](TetMesh& m) { m.surfaces["x_max"].col(0).swap(m.surfaces["x_max"].col(1)); });
  CHECK_SAYS(inward, "points into the tissue");
  const auto middles = refusal(to_quadratic(cube()),
                               [](TetMesh& m) { m.surfaces["x_max"].col(3).swap(m.surfaces["x_max"].col(4)); });
  CHECK_SAYS(middles, "surface \"x_max\": face 0 with node");
  CHECK_SAYS(middles, "The order is (0,1) (1,2) (2,0)");
}

TEST_CASE("a turned numbering of a face is accepted") {
  TetMesh mesh = to_quadratic(cube());
  Faces& faces = mesh.surfaces["y_min"];
  const Faces old = faces;
  for (int k = 0; k < 3; ++k) {
    faces.col(k) = old.col((k + 1) % 3);
    faces.col(3 + k) = old.col(3 + (k + 1) % 3);
  }
  CHECK_NOTHROW(check_mesh(mesh));
}

TEST_CASE("a surface with an edge of more than two faces is refused") {
  // Two cubes joined along one edge only: their hulls together have four faces there.
  TetMesh mesh = block_mesh(Block{});
  Block other;
  other.corner = {1, 1, 0};
  const TetMesh second = block_mesh(other);
  TetMesh both = combine_meshes(mesh, second, "a.", "b.");
  const auto fold = [&](std::int32_t node) {  // nodes 0 and 4 of the second are 3 and 7 of the first
    if (node < 8) return node;
    const std::int32_t local = node - 8;
    if (local == 0) return 3;
    if (local == 4) return 7;
    return 8 + local - (local > 4 ? 2 : 1);
  };
  CHECK(
      refusal(both,
              [&](TetMesh& m) {
                Points points(14, 3);
                for (std::int32_t n = 0; n < 16; ++n) points.row(fold(n)) = m.points.row(n);
                m.points = points;
                m.cells = m.cells.unaryExpr(fold);
                m.surfaces = {{"hull", boundary_of(m.cells).faces}};
                m.node_sets.clear();
              })
          .find(
              "surface \"hull\": more than two faces meet in the edge between node 3 at (1, 1, 0) m and node 7") !=
      std::string::npos);
}

TEST_CASE("an empty node set is refused") {
  CHECK_SAYS(refusal(cube(), [](TetMesh& m) { m.node_sets["none"].resize(0); }), "node set \"none\" is empty");
}

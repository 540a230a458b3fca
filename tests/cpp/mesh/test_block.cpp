#include <doctest/doctest.h>

#include "../approx.hpp"
#include "invariants.hpp"
#include "plica/core/error.hpp"
#include "plica/mesh/block.hpp"

using namespace plica;

namespace {
Block brick() {
  Block block;
  block.corner = {-1, 2, 0.5};
  block.size = {2, 0.5, 3};
  block.divisions = {3, 2, 4};
  return block;
}
}  // namespace

TEST_CASE("a block has six positive tetrahedra to a hexahedron and its exact volume") {
  const TetMesh mesh = block_mesh(brick());
  CHECK(mesh.cell_count() == 6 * 3 * 2 * 4);
  CHECK(mesh.node_count() == 4 * 3 * 5);
  const Vector volume = signed_volumes(mesh.points, mesh.cells);
  CHECK(volume.minCoeff() == approx(3.0 / mesh.cell_count()).epsilon(1e-12));
  CHECK(volume.sum() == approx(3.0).epsilon(1e-12));  // roundoff of 144 terms
}

TEST_CASE("every face of a block is shared by two cells or lies on its hull") {
  const TetMesh mesh = block_mesh(brick());
  const Boundary hull = boundary_of(mesh.cells);
  Eigen::Index single = 0;
  for (const auto& [face, uses] : test::face_uses(mesh.cells)) {
    CHECK((uses == 1 || uses == 2));
    single += uses == 1;
  }
  CHECK(single == hull.faces.rows());
  CHECK(single == 2 * 2 * (3 * 2 + 2 * 4 + 3 * 4));
  CHECK(test::area_vector(mesh.points, hull.faces).norm() < 1e-12);  // roundoff of areas near 1
  CHECK(test::enclosed_volume(mesh.points, hull.faces) == approx(3.0).epsilon(1e-12));
  for (Eigen::Index f = 0; f < single; ++f)
    for (int k = 0; k < 3; ++k) CHECK((mesh.cells.row(hull.cell_of_face[f]).array() == hull.faces(f, k)).any());
}

TEST_CASE("the named sides of a block point outward and cover it") {
  const TetMesh mesh = block_mesh(brick());
  const double areas[] = {1.5, 6, 1};
  const char* const names[3][2] = {{"x_min", "x_max"}, {"y_min", "y_max"}, {"z_min", "z_max"}};
  for (int d = 0; d < 3; ++d)
    for (int end = 0; end < 2; ++end) {
      const Vector3 area = test::area_vector(mesh.points, mesh.surface(names[d][end]));
      CHECK((area - (end ? 1 : -1) * areas[d] * Vector3::Unit(d)).norm() < 1e-12);
      const double level = brick().corner[d] + end * brick().size[d];
      for (const auto node : mesh.node_set(names[d][end])) CHECK(mesh.points(node, d) == level);
    }
  CHECK(mesh.node_set("z_min").size() == 4 * 3);
}

TEST_CASE("an unknown surface is refused with the names there are") {
  const TetMesh mesh = block_mesh(Block{});
  CHECK_THROWS_WITH_AS(mesh.surface("top"),
                       "TetMesh: surface = \"top\"; must be one of \"x_max\" \"x_min\" \"y_max\" \"y_min\" "
                       "\"z_max\" \"z_min\".",
                       InvalidInput);
  CHECK_THROWS_AS(mesh.node_set("wall"), InvalidInput);
}

TEST_CASE("a block without extent or divisions is refused") {
  Block block;
  block.size[1] = 0;
  CHECK_THROWS_WITH_AS(block_mesh(block), "Block: size.y = 0 m; must be > 0.", InvalidInput);
  block = Block{};
  block.divisions[2] = 0;
  CHECK_THROWS_WITH_AS(block_mesh(block), "Block: divisions.z = 0; must be >= 1.", InvalidInput);
}

TEST_CASE("combined meshes keep their labels and volumes and share no node") {
  TetMesh first = block_mesh(brick());
  first.cell_side.setConstant(static_cast<int>(Side::left));
  Block other = brick();
  other.corner[0] = 1;  // touches the first one
  other.divisions = {1, 1, 1};
  const TetMesh second = block_mesh(other);
  const TetMesh both = combine_meshes(first, second, "a.", "b.");
  CHECK(both.node_count() == first.node_count() + second.node_count());
  CHECK(signed_volumes(both.points, both.cells).sum() == approx(6.0).epsilon(1e-12));
  CHECK(both.layer_names == std::vector<std::string>{"a.body", "b.body"});
  CHECK(both.cell_layer.sum() == second.cell_count());
  CHECK(both.cell_side.sum() == first.cell_count());
  CHECK(both.surfaces.size() == 12);
  CHECK(both.surface("b.x_min").minCoeff() >= first.node_count());
  const Vector3 facing = test::area_vector(both.points, both.surface("a.x_max")) +
                         test::area_vector(both.points, both.surface("b.x_min"));
  CHECK(facing.norm() < 1e-12);
  for (const auto node : both.node_set("b.x_min")) CHECK(both.points(node, 0) == 1.0);
  CHECK(boundary_of(both.cells).faces.rows() ==
        boundary_of(first.cells).faces.rows() + boundary_of(second.cells).faces.rows());
  CHECK_THROWS_AS(combine_meshes(first, to_quadratic(second), "a.", "b."), InvalidInput);
  CHECK_THROWS_AS(combine_meshes(first, second, "a.", "a."), InvalidInput);
}

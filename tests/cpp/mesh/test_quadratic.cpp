#include <doctest/doctest.h>

#include <set>

#include "invariants.hpp"
#include "plica/core/error.hpp"
#include "plica/mesh/block.hpp"
#include "plica/mesh/larynx.hpp"

using namespace plica;

namespace {
constexpr int edge_ends[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
}

TEST_CASE("a quadratic mesh has one new node per edge, as Euler's formula counts them") {
  // V - E + F - C is 1 for a ball and 0 for a larynx (a solid torus).
  const std::pair<TetMesh, int> meshes[] = {{block_mesh({{0, 0, 0}, {1, 1, 1}, {2, 3, 2}}), 1},
                                            {larynx_mesh(Larynx::thesis_coarse()), 0}};
  for (const auto& [mesh, characteristic] : meshes) {
    const auto faces = static_cast<Eigen::Index>(test::face_uses(mesh.cells).size());
    const Eigen::Index edges = mesh.node_count() + faces - mesh.cell_count() - characteristic;
    CHECK(to_quadratic(mesh).node_count() == mesh.node_count() + edges);
  }
}

TEST_CASE("mid-side nodes lie in the middle of their edges and the corners stay") {
  const TetMesh linear = larynx_mesh(Larynx::thesis_coarse());
  const TetMesh mesh = to_quadratic(linear);
  CHECK(mesh.order() == 2);
  CHECK(mesh.points.topRows(linear.node_count()) == linear.points);
  CHECK(mesh.cells.leftCols(4) == linear.cells);
  CHECK(mesh.cell_layer == linear.cell_layer);
  double worst = 0;
  for (Eigen::Index e = 0; e < mesh.cell_count(); ++e)
    for (int k = 0; k < 6; ++k)
      worst = std::max(
          worst, (mesh.points.row(mesh.cells(e, 4 + k)) - 0.5 * (mesh.points.row(mesh.cells(e, edge_ends[k][0])) +
                                                                 mesh.points.row(mesh.cells(e, edge_ends[k][1]))))
                     .norm());
  CHECK(worst == 0);
}

TEST_CASE("the boundary of a quadratic mesh has its mid-side nodes in face order") {
  const TetMesh linear = block_mesh({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}});
  const TetMesh mesh = to_quadratic(linear);
  const Faces faces = boundary_of(mesh.cells).faces;
  CHECK(faces.leftCols(3) == boundary_of(linear.cells).faces);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      CHECK(mesh.points.row(faces(f, 3 + k)) ==
            0.5 * (mesh.points.row(faces(f, k)) + mesh.points.row(faces(f, (k + 1) % 3))));
}

TEST_CASE("surfaces and node sets follow to quadratic") {
  const TetMesh linear = block_mesh({{0, 0, 0}, {1, 1, 1}, {2, 3, 2}});
  const TetMesh mesh = to_quadratic(linear);
  const Faces& side = mesh.surface("y_max");
  CHECK(side.rows() == linear.surface("y_max").rows());
  std::set<std::int32_t> on_side(side.data(), side.data() + side.size());
  const Indices& nodes = mesh.node_set("y_max");
  CHECK(std::set<std::int32_t>(nodes.begin(), nodes.end()) == on_side);
  CHECK(nodes.size() == 5 * 5);
  for (const auto node : nodes) CHECK(mesh.points(node, 1) == 1.0);
}

TEST_CASE("a six-node face becomes four flat triangles of the same area vector") {
  const TetMesh mesh = to_quadratic(block_mesh(Block{}));
  const Faces& side = mesh.surface("z_max");
  const Triangles flat = flat_triangles(side);
  CHECK(flat.rows() == 4 * side.rows());
  for (Eigen::Index f = 0; f < side.rows(); ++f) {
    const Vector3 whole = test::area_vector(mesh.points, side(f, 0), side(f, 1), side(f, 2));
    for (int k = 0; k < 4; ++k) {
      const auto t = flat.row(4 * f + k);
      CHECK((4 * test::area_vector(mesh.points, t[0], t[1], t[2]) - whole).norm() < 1e-15);
      if (k < 3) CHECK(t[k] == side(f, k));
    }
  }
  const Faces linear = block_mesh(Block{}).surface("z_max");
  CHECK(flat_triangles(linear) == linear);
}

TEST_CASE("what is quadratic already, or has a surface off its edges, is refused") {
  TetMesh mesh = block_mesh({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}});
  CHECK_THROWS_WITH_AS(to_quadratic(to_quadratic(mesh)),
                       "to_quadratic: nodes per cell = 10; must be 4. Is the mesh quadratic already?",
                       InvalidInput);
  mesh.surfaces["x_min"](0, 0) = 26;
  CHECK_THROWS_AS(to_quadratic(mesh), InvalidInput);
}

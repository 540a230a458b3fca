#include <doctest/doctest.h>

#include "../approx.hpp"
#include "plica/dynamics/proximity.hpp"
#include "plica/mesh/block.hpp"

using namespace plica;

namespace {

/// Two unit blocks that face each other along x, 0.1 m apart; the second moves along x and along y.
struct Apart {
  TetMesh mesh = combine_meshes(block_mesh({{-1, 0, 0}, {1, 1, 1}, {2, 2, 2}}),
                                block_mesh({{0.1, 0, 0}, {1, 1, 1}, {2, 2, 2}}), "a.", "b.");
  Airway airway = matched_airway(mesh.points, flat_triangles(mesh.surface("a.x_max")),
                                 flat_triangles(mesh.surface("b.x_min")), Vector3::UnitX());
  Proximity proximity{airway, mesh.points, shapes()};

  Eigen::MatrixXd shapes() const {
    Eigen::MatrixXd shapes = Eigen::MatrixXd::Zero(mesh.points.size(), 2);
    for (std::ptrdiff_t i = mesh.node_count() / 2; i < mesh.node_count(); ++i)
      for (int axis = 0; axis < 2; ++axis) shapes(3 * i + axis, axis) = 1.0;
    return shapes;
  }
};

}  // namespace

TEST_CASE(
    "what nodes have slid past each other counts twice, in how far they are apart and in how far they came") {
  Apart blocks;
  Proximity& proximity = blocks.proximity;
  CHECK(proximity.closed(Eigen::Vector2d(-0.01, 0)) == approx(0.01).epsilon(1e-12));
  CHECK(proximity.closed(Eigen::Vector2d(0, 0.01)) == approx(0.02).epsilon(1e-12));
  const std::int32_t facing = blocks.airway.second(0, 0);
  const std::vector<std::int32_t> none;
  for (const double way : {0.03, -0.03}) {  // 0.1 - 2 * 0.03 = 0.04 m are left
    proximity.choose(Eigen::Vector2d(0, way), 0.039, none);
    CHECK_FALSE(proximity.is_near(facing));
    proximity.choose(Eigen::Vector2d(0, way), 0.041, none);
    CHECK(proximity.is_near(facing));
  }
}

TEST_CASE("what touches is near, however far its partner is") {
  Apart blocks;
  const std::int32_t touching = blocks.airway.first(0, 0);
  blocks.proximity.choose(Vector::Zero(2), 0.0, {});
  CHECK_FALSE(blocks.proximity.is_near(touching));
  blocks.proximity.choose(Vector::Zero(2), 0.0, {touching});
  CHECK(blocks.proximity.is_near(touching));
  CHECK_FALSE(blocks.proximity.surroundings(1).first.empty());
}

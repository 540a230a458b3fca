#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <numeric>

#include "../approx.hpp"
#include "plica/tissue/node_stress.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::Distorted;
using scenes::Kind;

TEST_CASE("a constant strain and strain rate have their exact stress at every node, a rotation has none") {
  for (const Kind kind : {Kind::linear, Kind::straight, Kind::curved}) {
    CAPTURE(static_cast<int>(kind));
    const Distorted scene(kind);
    const Material material = scenes::oblique();
    std::vector<std::int32_t> nodes(static_cast<std::size_t>(scene.mesh.node_count()));
    std::iota(nodes.begin(), nodes.end(), 0);
    const NodeStress stress(scene.mesh, scenes::uniform(scene.mesh, material), nodes);
    const auto at = [&](std::int32_t node, const Vector& u, const Vector& v) {
      Vector6 sum = Vector6::Zero();
      for (const auto& term : stress.at(node))
        sum += term.elastic * u.segment<3>(3 * term.node) + term.viscous * v.segment<3>(3 * term.node);
      return sum;
    };
    const Vector none = Vector::Zero(3 * scene.mesh.node_count());
    Matrix3 turn = Matrix3::Zero();
    turn(0, 1) = 1, turn(1, 0) = -1;
    const Vector rotation = scenes::affine_displacement(scene.mesh, turn);
    const Vector3 n = Vector3(0.3, -0.8, 0.5).normalized();
    for (const std::int32_t node : nodes) {
      for (int component = 0; component < 6; ++component) {
        const Vector field = scenes::affine_displacement(scene.mesh, scenes::unit_strain(component));
        const Vector6 elastic = elasticity_matrix(material).col(component),
                      viscous = viscosity_matrix(material).col(component);
        REQUIRE((at(node, field, none) - elastic).norm() < 1e-10 * elastic.norm());
        REQUIRE((at(node, none, field) - viscous).norm() < 1e-10 * viscous.norm());
      }
      REQUIRE(at(node, rotation, rotation).norm() < 1e-10 * elasticity_matrix(material).norm());
      // A unit stretch along n: its own stress along n, through the same functions.
      const Matrix3 stretch = n * n.transpose();
      REQUIRE(normal_dyad(n).dot(at(node, scenes::affine_displacement(scene.mesh, stretch), none)) ==
              approx(stress.modulus(node, n)).epsilon(1e-10));
    }
  }
}

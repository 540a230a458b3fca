// Exact properties of K on distorted meshes.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "../approx.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::Distorted;
using scenes::Kind;

namespace {

Indices inner_unknowns(const Distorted& scene) {
  Indices inner(3 * std::count(scene.hull.begin(), scene.hull.end(), 0));
  std::int32_t next = 0;
  for (std::int32_t i = 0; i < scene.mesh.node_count(); ++i) {
    for (int d = 0; d < 3 && !scene.hull[static_cast<std::size_t>(i)]; ++d) inner[next++] = 3 * i + d;
  }
  return inner;
}

}  // namespace

// Holds on curved inner elements too: isoparametric functions contain every affine field, and
// grad N det J is a polynomial of degree 3 there, within the degree 5 of the rule.
TEST_CASE("every constant strain of a distorted mesh gives no inner nodal force and the exact energy") {
  for (const Kind kind : scenes::kinds) {
    const Distorted scene(kind);
    const Material material = scenes::oblique();
    const Assembler assembler(scene.mesh);
    const BlockMatrix K = assembler.stiffness(scenes::uniform(scene.mesh, material));
    const Matrix6 S = elasticity_matrix(material);
    const auto inner = inner_unknowns(scene);
    REQUIRE(inner.size() >= 24);
    for (int component = 0; component < 6; ++component) {
      CAPTURE(static_cast<int>(kind));
      CAPTURE(component);
      const Vector u = scenes::affine_displacement(scene.mesh, scenes::unit_strain(component));
      const Vector f = K * u;
      CHECK(f.norm() > 1e3);
      CHECK(f(inner).lpNorm<Eigen::Infinity>() < 1e-12 * f.lpNorm<Eigen::Infinity>());
      // Energy of the constant strain, volume by the box.
      const double volume = scene.block.size[0] * scene.block.size[1] * scene.block.size[2];
      CHECK(u.dot(f) == approx(volume * S(component, component)).epsilon(1e-12));
    }
  }
}

TEST_CASE("an infinitesimal rigid motion costs no force, elastic or viscous") {
  for (const Kind kind : scenes::kinds) {
    const Distorted scene(kind);
    const Assembler assembler(scene.mesh);
    const Tissue tissue = scenes::uniform(scene.mesh, scenes::oblique());
    const BlockMatrix K = assembler.stiffness(tissue), C = assembler.viscosity(tissue);
    // Round-off of sums over some 100 blocks of the size of the largest entry.
    const auto largest = [](const BlockMatrix& A) {
      return Eigen::Map<const Vector>(A.values().data(), static_cast<int>(A.values().size()))
          .lpNorm<Eigen::Infinity>();
    };
    for (int motion = 0; motion < 6; ++motion) {
      CAPTURE(static_cast<int>(kind));
      CAPTURE(motion);
      Vector u(K.rows());
      for (std::ptrdiff_t i = 0; i < scene.mesh.node_count(); ++i) {
        const Vector3 axis = Vector3::Unit(motion % 3), x = scene.mesh.points.row(i);
        as_points(u).row(i) = (motion < 3 ? axis : axis.cross(x)).transpose();
      }
      CHECK((K * u).lpNorm<Eigen::Infinity>() < 1e-13 * largest(K));
      CHECK((C * u).lpNorm<Eigen::Infinity>() < 1e-13 * largest(C));
    }
  }
}

TEST_CASE("the stiffness matrix of a free body has exactly six zero eigenvalues") {
  for (const int order : {1, 2}) {
    CAPTURE(order);
    TetMesh mesh = block_mesh(Block{});
    if (order == 2) mesh = to_quadratic(mesh);
    const BlockMatrix K = Assembler(mesh).stiffness(scenes::uniform(mesh, scenes::oblique()));
    const Vector values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K.to_sparse().toDense()).eigenvalues();
    CHECK(values.head(6).cwiseAbs().maxCoeff() < 1e-12 * values.maxCoeff());
    CHECK(values[6] > 1e-4 * values.maxCoeff());
  }
}

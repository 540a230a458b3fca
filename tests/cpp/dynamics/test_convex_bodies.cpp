// Smooth convex bodies of unlike meshes in random positions, thrown at each other.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <random>

#include "plica/meshing/triangulated_airway.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }

 private:
  std::mt19937 engine_;
};

/// Nearly an ellipsoid of half-axes 5 to 10 mm, so many cells across, turned by up to 0.3 about each axis.
TetMesh pebble(int across, Random& random) {
  constexpr double round = 0.8;  // 1 is a ball, whose outermost cells are flat
  TetMesh mesh = block_mesh({{-1, -1, -1}, {2, 2, 2}, {across, across, across}});
  Matrix3 shape = Matrix3::Identity();
  for (int d = 0; d < 3; ++d) shape(d, d) = 8e-3 * random.between(0.6, 1.2);
  for (int d = 0; d < 3; ++d)
    shape = Eigen::AngleAxisd(random.between(-0.3, 0.3), Vector3::Unit(d)).toRotationMatrix() * shape;
  for (std::ptrdiff_t i = 0; i < mesh.node_count(); ++i) {
    const Vector3 p = mesh.points.row(i).transpose();
    const double largest = p.cwiseAbs().maxCoeff();
    mesh.points.row(i) = (shape * p * (largest > 0 ? 1 - round + round * largest / p.norm() : 1)).transpose();
  }
  return mesh;
}

/// Two of them, 0.02 mm apart at their foremost nodes, off each other's line, with mortar faces.
Scene thrown(unsigned seed, double speed, SurfaceMass mass) {
  Random random(seed);
  TetMesh a = pebble(5, random), b = pebble(4, random);
  a.points.col(0).array() -= a.points.col(0).maxCoeff() + 2e-5;
  b.points.col(0).array() -= b.points.col(0).minCoeff();
  for (int d = 1; d < 3; ++d) b.points.col(d).array() += random.between(-1e-3, 1e-3);
  Scene scene = scenes::tissue_scene(combine_meshes(a, b, "a.", "b."), 0.3, 0.0);
  const auto nodes = scene.mesh.node_count();
  scene.velocity = Points::Zero(nodes, 3);
  scene.velocity->col(0).head(a.node_count()).setConstant(0.5 * speed);
  scene.velocity->col(0).tail(nodes - a.node_count()).setConstant(-0.5 * speed);
  const Faces &first = scene.mesh.surface("a.x_max"), &second = scene.mesh.surface("b.x_min");
  scene.contact = ContactPart{triangulated_airway(scene.mesh.points, first, second), Multipliers{}, {}};
  scene.contact->surface_mass = mass;
  scene.contact->faces = Mortar{first, second};
  return scene;
}

}  // namespace

TEST_CASE("convex bodies on mortar faces bounce with no more energy than they came with") {
  int touching = 0;
  for (unsigned seed = 1; seed <= 2; ++seed)
    for (const double speed : {0.1, 0.5})
      for (const SurfaceMass mass : {SurfaceMass::kept, SurfaceMass::redistributed}) {
        CAPTURE(seed);
        CAPTURE(speed);
        Simulation simulation(thrown(seed, speed, mass), options(HilberHughesTaylor{-0.3}, 5e-5, 1e-11));
        const double initial = simulation.state().ledger.initial;
        double most = 0, off = 0;
        for (int k = 0; k < (speed < 0.3 ? 90 : 50); ++k) {
          simulation.advance();
          touching += simulation.record().contact->rows > 0;
          const Ledger& ledger = simulation.state().ledger;
          most = std::max(most, ledger.kinetic + ledger.elastic);
          off = std::max(off, std::abs(ledger.error()));
        }
        // Contact is solved to 1e-5 edges, whose share of the bodies' motion in a step is 1e-2 at 0.1 m/s.
        CHECK(most < 1.01 * initial);
        CHECK(off < 1e-9 * initial);
      }
  CHECK(touching > 100);
}

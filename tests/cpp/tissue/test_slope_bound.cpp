#include <doctest/doctest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "plica/mesh/block.hpp"
#include "plica/tissue/internal_force.hpp"
#include "plica/tissue/slope_bound.hpp"

using namespace plica;

namespace {

/// Viscous tissue with fibres that stiffen, in cells with straight and with curved sides.
struct StiffeningBlock {
  TetMesh mesh = block_mesh({{0.001, 0.002, 0}, {0.01, 0.02, 0.005}, {2, 3, 1}});
  Tissue tissue;

  StiffeningBlock(int order, bool curved) {
    if (order == 2) mesh = to_quadratic(mesh);
    if (curved) mesh.points += as_points(swayed(0.2));
    Material cover{TransverselyIsotropic{1e3, 0.66, 10e3, 0.66, 10e3, {}, Vector3(0.2, 1, -0.3)}};
    cover.stiffening = 3;
    cover.matrix_stiffening = 2;
    cover.active_stress = 2e3;
    cover.viscosity = 0.4;
    tissue = {{cover, Material{Isotropic{20e3, 0.3}}}, {"cover", "body"}, Indices::Zero(mesh.cell_count())};
    for (std::ptrdiff_t c = 0; c < mesh.cell_count(); c += 3) tissue.cell_material[c] = 1;
  }
  /// (3 n) m, a smooth field of displacements.
  Vector swayed(double size) const {
    Points u = mesh.points;
    for (auto row : u.rowwise()) {
      const Eigen::RowVector3d x = row;
      row = size * Eigen::RowVector3d(3e-3 * std::sin(200 * x[1]), 0.2 * x[1] + 20 * x[0] * x[2],
                                      1e-3 * std::cos(300 * x[0]));
    }
    return as_vector(u);
  }
  /// elastic K + viscous C at u, C column by column, as the viscous force is linear in v.
  Eigen::MatrixXd slopes(const Vector& u, double elastic, double viscous) const {
    Eigen::MatrixXd sum =
        elastic * Eigen::MatrixXd(Assembler(mesh).stretched(tissue, mesh.points + as_points(u)).slope.to_sparse());
    const InternalForce law(mesh, tissue);
    InternalForce::Force force;
    for (std::ptrdiff_t k = 0; k < u.size(); ++k) {
      REQUIRE(!law.at(u, Vector::Unit(u.size(), k), force));
      sum.col(k) += viscous * force.viscous;
    }
    return sum;
  }
  /// The largest eigenvalue of M^-1 A.
  double by_mass(const Eigen::MatrixXd& A) const {
    const Vector mass = Assembler(mesh).lumped_mass(tissue);
    Vector scale(A.rows());
    for (std::ptrdiff_t i = 0; i < mass.size(); ++i) scale.segment<3>(3 * i).setConstant(1 / std::sqrt(mass[i]));
    const Eigen::MatrixXd scaled = scale.asDiagonal() * A * scale.asDiagonal();
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(0.5 * (scaled + scaled.transpose()),
                                                          Eigen::EigenvaluesOnly)
        .eigenvalues()
        .tail<1>()[0];
  }
};

}  // namespace

TEST_CASE("slope bound: no eigenvalue of the whole is above it, nor what one has grown by") {
  for (const auto& [order, curved] : {std::pair{1, false}, {2, false}, {2, true}}) {
    const StiffeningBlock block(order, curved);
    const SlopeBound bound(block.mesh, block.tissue);
    const Vector known = block.swayed(0.3);
    for (const auto& [elastic, viscous] : {std::pair{1e-9, 0.0}, {0.0, 1e-4}, {1e-9, 1e-4}}) {
      const Eigen::MatrixXd before = block.slopes(known, elastic, viscous);
      for (const double size : {0.31, 0.6}) {
        const Vector u = block.swayed(size);
        const Eigen::MatrixXd now = block.slopes(u, elastic, viscous);
        const double largest = block.by_mass(now), grown = block.by_mass(now - before);
        REQUIRE(largest > 0);
        REQUIRE(grown > 0);
        const double above = bound.at(u, elastic, viscous).value,
                     above_change = bound.change(known, u, elastic, viscous).value;
        CHECK(above >= largest);
        CHECK(above < 8 * largest);  // of cells alone, and of discs of their eigenvalues
        CHECK(above_change >= grown);
        CHECK(above_change < 12 * grown);
      }
    }
    CHECK(bound.change(known, known, 1e-9, 1e-4).value == 0);
  }
}

TEST_CASE("slope bound: it is that of the stiffest cell, and none where a cell is inside out") {
  StiffeningBlock block(1, false);
  block.tissue.materials.push_back(Material{Isotropic{2e6, 0.3}});
  block.tissue.names.push_back("bone");
  block.tissue.cell_material[17] = 2;
  const SlopeBound bound(block.mesh, block.tissue);
  CHECK(bound.at(block.swayed(0.3), 1e-9, 0.0).cell == 17);
  Vector folded = block.swayed(0.0);
  const std::int32_t* cell = block.mesh.cells.row(5).data();
  folded.segment<3>(3 * cell[0]) =
      2 * (block.mesh.points.row(cell[1]) - block.mesh.points.row(cell[0])).transpose() +
      (block.mesh.points.row(cell[2]) - block.mesh.points.row(cell[0])).transpose();
  CHECK(std::isinf(bound.at(folded, 1e-9, 0.0).value));
  CHECK(std::isinf(bound.change(folded, block.swayed(0.0), 1e-9, 0.0).value));
}

TEST_CASE("slope bound: a body that turns is as stiff as before") {
  const StiffeningBlock block(1, false);
  const SlopeBound bound(block.mesh, block.tissue);
  const Matrix3 turn = Eigen::AngleAxisd(1.1, Vector3(1, 2, -1).normalized()).toRotationMatrix();
  const Points bent = block.mesh.points + as_points(block.swayed(0.4));
  const Vector turned = as_vector(Points(bent * turn.transpose() - block.mesh.points));
  const double still = block.by_mass(block.slopes(block.swayed(0.4), 1e-9, 1e-4));
  CHECK(block.by_mass(block.slopes(turned, 1e-9, 1e-4)) == doctest::Approx(still).epsilon(1e-9));
  const double of_still = bound.at(block.swayed(0.4), 1e-9, 1e-4).value;
  CHECK(bound.at(turned, 1e-9, 1e-4).value >= still);
  CHECK(bound.at(turned, 1e-9, 1e-4).value < 2 * of_still);
}

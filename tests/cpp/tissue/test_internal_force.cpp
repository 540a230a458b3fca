#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "plica/core/threads.hpp"
#include "plica/mesh/block.hpp"
#include "plica/tissue/element.hpp"
#include "plica/tissue/internal_force.hpp"
#include "plica/tissue/stretch_law.hpp"

using namespace plica;

namespace {

enum class CellShape { linear, straight, curved };
constexpr CellShape all_shapes[] = {CellShape::linear, CellShape::straight, CellShape::curved};

Tissue two_tissues(const TetMesh& mesh) {
  Material cover{TransverselyIsotropic{1e3, 0.66, 10e3, 0.66, 10e3, {}, Vector3(0.2, 1, -0.3)}};
  cover.stiffening = 3;
  cover.matrix_stiffening = 2;
  cover.active_stress = 2e3;
  cover.viscosity = 0.4;
  Material body{Isotropic{20e3, 0.3}};
  Tissue tissue{{cover, body}, {"cover", "body"}, Indices::Zero(mesh.cell_count())};
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); c += 3) tissue.cell_material[c] = 1;
  return tissue;
}

/// A smooth field of displacements.
Points bent(const Points& x, double size) {
  Points u(x.rows(), 3);
  for (std::ptrdiff_t i = 0; i < x.rows(); ++i)
    u.row(i) = size * Eigen::RowVector3d(3e-3 * std::sin(200 * x(i, 1)), 0.2 * x(i, 1) + 20 * x(i, 0) * x(i, 2),
                                         1e-3 * std::cos(300 * x(i, 0)));
  return u;
}

TetMesh block(CellShape cells) {
  TetMesh mesh = block_mesh({{0.001, 0.002, 0}, {0.01, 0.02, 0.005}, {2, 3, 1}});
  if (cells != CellShape::linear) mesh = to_quadratic(mesh);
  if (cells == CellShape::curved) mesh.points += bent(mesh.points, 0.2);
  return mesh;
}

InternalForce::Force force_at(const InternalForce& law, const Points& u, const Points& v) {
  InternalForce::Force force;
  REQUIRE(!law.at(as_vector(u), as_vector(v), force));
  return force;
}

}  // namespace

TEST_CASE("internal force: it is the force of stretched tissue") {
  for (const CellShape cells : all_shapes) {
    const TetMesh mesh = block(cells);
    const Tissue tissue = two_tissues(mesh);
    const Points u = bent(mesh.points, 0.5);
    const Vector expected = Assembler(mesh).stretched(tissue, mesh.points + u).force;
    const auto found = force_at(InternalForce(mesh, tissue), u, u);
    CHECK((found.elastic - expected).norm() < 1e-12 * expected.norm());
  }
}

TEST_CASE("internal force: of a mesh at a posture it counts from rest, displacements from the posture") {
  for (const CellShape cells : all_shapes) {
    TetMesh mesh = block(cells);
    const Tissue tissue = two_tissues(mesh);
    mesh.rest = mesh.points;
    mesh.points += bent(mesh.points, 0.3);
    const Points u = bent(mesh.points, -0.2);
    const Vector expected = Assembler(mesh).stretched(tissue, mesh.points + u).force;
    const auto found = force_at(InternalForce(mesh, tissue), u, u);
    CHECK((found.elastic - expected).norm() < 1e-12 * expected.norm());
  }
}

TEST_CASE("internal force: small motion has the matrices of its shape, with and without a posture") {
  for (const CellShape cells : all_shapes) {
    for (const bool stretched : {false, true}) {
      TetMesh mesh = block(cells);
      const Tissue tissue = two_tissues(mesh);
      if (stretched) {
        mesh.rest = mesh.points;
        mesh.points += bent(mesh.points, 0.3);
      }
      const Assembler assembler(mesh);
      const InternalForce law(mesh, tissue);
      const Points none = Points::Zero(mesh.node_count(), 3);
      const double size = 1e-6;
      const Points u = bent(mesh.points, size), v = bent(mesh.points, 1.0);
      const Vector change = force_at(law, u, none).elastic - force_at(law, none, none).elastic;
      const Vector Ku = assembler.stretched(tissue, mesh.points).slope * Vector(as_vector(u));
      CHECK((change - Ku).norm() < 1e-5 * Ku.norm());
      const Vector Cv = assembler.viscosity(tissue) * Vector(as_vector(v));
      CHECK((force_at(law, none, v).viscous - Cv).norm() < 1e-12 * Cv.norm());
    }
  }
}

TEST_CASE("internal force: it is the gradient of the energy, which is that of the law") {
  for (const CellShape cells : all_shapes) {
    const TetMesh mesh = block(cells);
    const Tissue tissue = two_tissues(mesh);
    const InternalForce law(mesh, tissue);
    const Points u = bent(mesh.points, 0.6);
    const Vector force = force_at(law, u, u).elastic;
    constexpr double h = 1e-8;
    for (const int node : {0, 5, 17})
      for (int k = 0; k < 3; ++k) {
        Points more = u, less = u;
        more(node, k) += h;
        less(node, k) -= h;
        const double slope = (law.energy(as_vector(more)) - law.energy(as_vector(less))) / (2 * h);
        CHECK(std::abs(force[3 * node + k] - slope) < 1e-6 * force.cwiseAbs().maxCoeff());
      }
    const Matrix3 F = Vector3(1.1, 0.9, 1.3).asDiagonal();
    const Points even = mesh.points * (F - Matrix3::Identity());
    double expected = 0;
    Element element(mesh.order());
    for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c) {
      element.place(mesh.points, mesh.cells.row(c).data());
      const auto& material = tissue.materials[static_cast<std::size_t>(tissue.cell_material[c])];
      expected += element.volume() * StretchLaw(material).energy(F);
    }
    CHECK(std::abs(law.energy(as_vector(even)) - expected) < 1e-12 * expected);
  }
}

TEST_CASE("internal force: the energy of a small field is half u K u, to its digits") {
  for (const CellShape cells : all_shapes) {
    const TetMesh mesh = block(cells);
    Tissue tissue = two_tissues(mesh);
    tissue.materials[0].active_stress = 0;
    REQUIRE(tissue.materials[0].matrix_stiffening > 0);
    const InternalForce law(mesh, tissue);
    const Vector u = as_vector(bent(mesh.points, 1e-7));
    const double half = 0.5 * u.dot(Assembler(mesh).stiffness(tissue) * u);
    // The third order, which changes its sign with u, has no part in the mean.
    const double mean = 0.5 * (law.energy(u) + law.energy(-u));
    CHECK(std::abs(mean - half) < 1e-8 * half);
    CHECK(std::abs(law.energy(u) - half) < 1e-6 * half);
  }
}

TEST_CASE("internal force: a rigid motion costs nothing, and a small strain of a turned body keeps its digits") {
  for (const CellShape cells : all_shapes) {
    const TetMesh mesh = block(cells);
    Tissue tissue = two_tissues(mesh);
    tissue.materials[0].active_stress = 0;
    const InternalForce law(mesh, tissue);
    const Matrix3 R = Eigen::AngleAxisd(0.9, Vector3(1, 2, -1).normalized()).toRotationMatrix();
    const Vector3 spin(30, -20, 50);  // rad/s
    Points u = mesh.points * (R - Matrix3::Identity()).transpose(), v = u;
    u.rowwise() += Eigen::RowVector3d(0.003, -0.002, 0.001);
    for (std::ptrdiff_t i = 0; i < v.rows(); ++i) v.row(i) = spin.cross(Vector3(mesh.points.row(i) + u.row(i)));
    const auto turned = force_at(law, u, v);
    const Points bend = bent(mesh.points, 0.1);
    const auto strained = force_at(law, bend, Points(600 * bend));  // as fast as it turns
    CHECK(turned.elastic.norm() < 1e-12 * strained.elastic.norm());
    CHECK(turned.viscous.norm() < 1e-12 * strained.viscous.norm());
    CHECK(std::abs(law.energy(as_vector(u))) < 1e-13 * law.energy(as_vector(bend)));

    const double tiny = 1e-7;
    const Points stretched = ((mesh.points + bent(mesh.points, tiny)) * R.transpose() - mesh.points).eval();
    const Vector expected = Assembler(mesh).stiffness(tissue) * Vector(as_vector(bent(mesh.points, tiny)));
    const Vector back = as_vector(Points(as_points(force_at(law, stretched, v).elastic) * R));
    CHECK((back - expected).norm() < 1e-5 * expected.norm());
  }
}

TEST_CASE("internal force: the viscosity takes eta d : d of the volume there is") {
  for (const CellShape cells : all_shapes) {
    const TetMesh mesh = block(cells);
    Tissue tissue = two_tissues(mesh);
    tissue.cell_material.setZero();
    const InternalForce law(mesh, tissue);
    Matrix3 F, L;
    F << 1.2, 0.3, -0.1, 0.1, 0.9, 0.2, -0.2, 0.1, 1.1;
    L << 3, -2, 1, 4, 2, -5, 1, 1, -2;  // 1/s
    const Points x = mesh.points * F.transpose(), v = x * L.transpose();
    const auto force = force_at(law, Points(x - mesh.points), v);
    const Matrix3 d = 0.5 * (L + L.transpose());
    double volume = 0;
    Element element(mesh.order());
    for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c) {
      element.place(mesh.points, mesh.cells.row(c).data());
      volume += element.volume();
    }
    const double expected = 0.4 * d.squaredNorm() * F.determinant() * volume;
    CHECK(std::abs(force.viscous.dot(Vector(as_vector(v))) - expected) < 1e-12 * expected);
  }
}

TEST_CASE("internal force: a cell inside out is named, and so is a force that is not finite") {
  const TetMesh mesh = block(CellShape::straight);
  const InternalForce law(mesh, two_tissues(mesh));
  InternalForce::Force force;
  Points u = Points::Zero(mesh.node_count(), 3);
  const std::int32_t corner = mesh.cells(7, 2);
  u.row(corner) = 4 * (mesh.points.row(mesh.cells(7, 0)) - mesh.points.row(corner));
  const auto cell = law.at(as_vector(u), as_vector(u), force);
  REQUIRE(cell);
  CHECK((mesh.cells.row(*cell).array() == corner).any());
  CHECK(std::isnan(law.energy(as_vector(u))));
  const Points far = 1e3 * mesh.points;  // exp overflows
  CHECK(law.at(as_vector(far), as_vector(far), force).has_value());
}

TEST_CASE("internal force: the same bits for any number of threads") {
  const TetMesh mesh = to_quadratic(block_mesh({{0, 0, 0}, {0.01, 0.02, 0.005}, {4, 6, 3}}));
  const InternalForce law(mesh, two_tissues(mesh));
  const Points u = bent(mesh.points, 0.3), v = bent(mesh.points, 2.0);
  const auto one = force_at(law, u, v);
  const double energy = law.energy(as_vector(u));
  set_threads(2);
  const auto two = force_at(law, u, v);
  CHECK(law.energy(as_vector(u)) == energy);
  set_threads(1);
  CHECK(one.elastic == two.elastic);
  CHECK(one.viscous == two.viscous);
}

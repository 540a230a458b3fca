#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "plica/core/error.hpp"
#include "plica/mesh/block.hpp"
#include "plica/tissue/assembly.hpp"
#include "plica/tissue/stretch_law.hpp"

using namespace plica;

namespace {

bool close(double found, double expected, double within) { return std::abs(found - expected) <= within; }

Material cover() {
  Material material{TransverselyIsotropic{1e3, 0.66, 10e3, 0.66, 10e3, {}, Vector3(0.2, 1, -0.3)}};
  material.stiffening = 3;
  material.matrix_stiffening = 2;
  material.active_stress = 2e3;
  return material;
}

Matrix3 some_deformation(double size) {
  Matrix3 H;
  H << 0.3, -0.5, 0.2, 0.1, 0.8, -0.4, -0.2, 0.6, -0.1;
  return Matrix3::Identity() + size * H;
}

/// A block whose nodes are moved by a smooth field, and its tissue.
struct Bent {
  TetMesh mesh = block_mesh({{0.001, 0.002, 0}, {0.01, 0.02, 0.005}, {2, 3, 2}});
  Tissue tissue;
  explicit Bent(int order) {
    if (order == 2) mesh = to_quadratic(mesh);
    tissue = {{cover()}, {"cover"}, Indices::Zero(mesh.cell_count())};
  }
  Points moved(double size) const {
    Points x = mesh.points;
    for (auto row : x.rowwise())
      row += size * Eigen::RowVector3d(3e-3 * std::sin(200 * row[1]), 0.2 * row[1] + 20 * row[0] * row[2],
                                       1e-3 * std::cos(300 * row[0]));
    return x;
  }
  double energy(const Points& x) const {
    REQUIRE(mesh.order() == 1);
    const StretchLaw law(tissue.materials[0]);
    double sum = 0;
    for (const auto& cell : mesh.cells.rowwise()) {
      Matrix3 at, rest;
      for (int k = 0; k < 3; ++k) {
        at.col(k) = (x.row(cell[k + 1]) - x.row(cell[0])).transpose();
        rest.col(k) = (mesh.points.row(cell[k + 1]) - mesh.points.row(cell[0])).transpose();
      }
      sum += rest.determinant() / 6 * law.energy(at * rest.inverse());
    }
    return sum;
  }
};

}  // namespace

TEST_CASE("stretch law: at rest it is that of small strains") {
  for (const bool fibred : {true, false}) {
    Material material = fibred ? cover() : Material{Isotropic{3e3, 0.45}};
    material.active_stress = 0;
    const auto [stress, slope] = StretchLaw(material).at(Matrix3::Identity());
    const Matrix6 S = elasticity_matrix(material);
    CHECK(stress.norm() < 1e-12 * S.norm());
    CHECK((slope - S).norm() < 1e-12 * S.norm());
  }
}

TEST_CASE("stretch law: isotropic tissue is neo-Hookean") {
  const double E = 3e3, nu = 0.4, mu = E / (2 * (1 + nu)), lambda = E * nu / ((1 + nu) * (1 - 2 * nu));
  const Matrix3 F = some_deformation(0.4);
  const Matrix3 P = F * StretchLaw({Isotropic{E, nu}}).at(F).stress;
  const Matrix3 turned = F.inverse().transpose();
  const Matrix3 expected = mu * (F - turned) + lambda * std::log(F.determinant()) * turned;
  CHECK((P - expected).norm() < 1e-12 * expected.norm());
}

TEST_CASE("stretch law: what is not isotropic across its fibre is refused") {
  TransverselyIsotropic law{1e3, 0.66, 10e3, 0.66, 10e3, 500.0, Vector3::UnitY()};
  CHECK_THROWS_WITH_AS(StretchLaw(Material{law}), doctest::Contains("mu = 500"), InvalidInput);
}

TEST_CASE("stretch law: the slope is that of the stress") {
  const StretchLaw law(cover());
  constexpr double h = 1e-6;
  for (const double size : {0.4, -0.3}) {
    const Matrix3 F = some_deformation(size);
    const auto [stress, slope] = law.at(F);
    Matrix3 H;
    H << 0.2, 0.7, -0.4, 0.3, -0.6, 0.5, 0.8, -0.1, 0.4;
    const Matrix3 change = (law.at(F + h * H).stress - law.at(F - h * H).stress) / (2 * h);
    const Matrix3 strain = 0.5 * (H.transpose() * F + F.transpose() * H);
    Vector6 given;
    given << strain(0, 0), strain(1, 1), strain(2, 2), 2 * strain(0, 1), 2 * strain(1, 2), 2 * strain(2, 0);
    const Vector6 answer = slope * given;
    Matrix3 expected;
    expected << answer[0], answer[3], answer[5], answer[3], answer[1], answer[4], answer[5], answer[4], answer[2];
    CHECK((change - expected).norm() < 1e-6 * expected.norm());
  }
}

TEST_CASE("stretch law: stress is the gradient of the energy") {
  const StretchLaw law(cover());
  constexpr double h = 1e-5;
  for (const double size : {0.4, -0.3}) {  // the fibre is longer in one, shorter in the other
    const Matrix3 F = some_deformation(size);
    const Matrix3 P = F * law.at(F).stress;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        Matrix3 more = F, less = F;
        more(i, j) += h;
        less(i, j) -= h;
        CHECK(close(P(i, j), (law.energy(more) - law.energy(less)) / (2 * h), 1e-4));
      }
  }
}

TEST_CASE("stretch law: a rotation costs nothing and turns with the body") {
  const StretchLaw law(cover());
  const Matrix3 R = Eigen::AngleAxisd(0.7, Vector3(1, 2, -1).normalized()).toRotationMatrix();
  const Matrix3 F = some_deformation(0.3);
  CHECK(close(law.energy(R * F), law.energy(F), 1e-12 * law.energy(F)));
  CHECK((law.at(R * F).stress - law.at(F).stress).norm() < 1e-11 * law.at(F).stress.norm());
}

TEST_CASE("stretch law: fibres add E' q (exp(k (lambda^2 - 1)^2) - 1) where they are in tension") {
  Material material{TransverselyIsotropic{1e3, 0.3, 40e3, 0.2, 10e3, {}, Vector3::UnitY()}};
  Material stiff = material;
  stiff.stiffening = 2.5;
  for (const double lambda : {0.8, 1.0, 1.1, 1.4}) {
    const double q = (lambda * lambda - 1) / 2;
    const double expected = q > 0 ? 40e3 * q * std::expm1(2.5 * 4 * q * q) : 0;
    const Matrix3 F = Vector3(0.9, lambda, 1.05).asDiagonal();
    const Matrix3 more = StretchLaw(stiff).at(F).stress - StretchLaw(material).at(F).stress;
    CHECK(close(more(1, 1), expected, 1e-9));
    CHECK(close(more.norm(), expected, 1e-9));
  }
}

TEST_CASE("stretch law: in simple shear the matrix bears mu gamma (1 + m gamma^2 / 2)") {
  const double E = 3e3, nu = 0.4, mu = E / (2 * (1 + nu)), m = 4;
  Material stiff{Isotropic{E, nu}};
  stiff.matrix_stiffening = m;
  for (const double gamma : {1e-9, 0.3, 1.0, -1.5}) {
    Matrix3 F = Matrix3::Identity();
    F(0, 2) = gamma;
    const Matrix3 P = F * StretchLaw(stiff).at(F).stress;
    const double expected = mu * gamma * (1 + m * gamma * gamma / 2);
    CHECK(close(P(0, 2), expected, 1e-12 * mu));
    CHECK(close(StretchLaw(stiff).energy(F), mu * gamma * gamma / 2 * (1 + m * gamma * gamma / 4), 1e-12 * mu));
  }
}

TEST_CASE("stretch law: a matrix that stiffens, in a stretch at constant volume, is that of Yeoh") {
  // Cauchy's stress difference mu (1 + m (I1 - 3) / 2) (lambda^2 - 1 / lambda).
  const double E = 3e3, nu = 0.4, mu = E / (2 * (1 + nu)), m = 4;
  Material stiff{Isotropic{E, nu}};
  stiff.matrix_stiffening = m;
  for (const double lambda : {0.6, 0.9, 1.2, 1.7}) {
    const Matrix3 F = Vector3(lambda, 1 / std::sqrt(lambda), 1 / std::sqrt(lambda)).asDiagonal();
    const Matrix3 cauchy = F * StretchLaw(stiff).at(F).stress * F.transpose();
    const double expected = mu * (1 + m * (lambda * lambda + 2 / lambda - 3) / 2) * (lambda * lambda - 1 / lambda);
    CHECK(close(cauchy(0, 0) - cauchy(1, 1), expected, 1e-11 * std::abs(expected)));
  }
}

TEST_CASE("stretched tissue: the slope is that of the force, to second order") {
  for (const int order : {1, 2}) {
    const Bent bent(order);
    const Assembler assembler(bent.mesh);
    const Points x = bent.moved(0.5);
    const auto [force, slope] = assembler.stretched(bent.tissue, x);
    Points direction = bent.moved(1.0) - bent.mesh.points;
    direction.col(0).swap(direction.col(2));
    const Vector linear = slope * Vector(as_vector(direction));
    const auto left = [&](double h) {
      const Vector more = assembler.stretched(bent.tissue, x + h * direction).force;
      const Vector less = assembler.stretched(bent.tissue, x - h * direction).force;
      return ((more - less) / (2 * h) - linear).norm() / linear.norm();
    };
    CHECK(left(0.02) < 0.05);
    CHECK(close(left(0.01), left(0.02) / 4, 0.06 * left(0.02)));
    CHECK(left(1e-4) < 1e-6);
    const SparseMatrix K = slope.to_sparse();
    CHECK(SparseMatrix(K - SparseMatrix(K.transpose())).norm() < 1e-13 * K.norm());
  }
}

TEST_CASE("stretched tissue: the force is the gradient of the energy") {
  const Bent bent(1);
  const Points x = bent.moved(0.6);
  const Vector force = Assembler(bent.mesh).stretched(bent.tissue, x).force;
  constexpr double h = 1e-8;
  for (const std::int32_t node : {0, 5, 17}) {
    for (int k = 0; k < 3; ++k) {
      Points more = x, less = x;
      more(node, k) += h;
      less(node, k) -= h;
      CHECK(close(force[3 * node + k], (bent.energy(more) - bent.energy(less)) / (2 * h),
                  1e-6 * force.cwiseAbs().maxCoeff()));
    }
  }
}

TEST_CASE("stretched tissue: patch test at finite stretch, and quadratic cells agree with linear ones") {
  const Matrix3 F = some_deformation(0.4);
  Vector corner_force;
  for (const int order : {1, 2}) {
    Bent bent(order);
    const Points x = (bent.mesh.points * F.transpose()).eval();
    const auto found = Assembler(bent.mesh).stretched(bent.tissue, x);
    const Boundary boundary = boundary_of(bent.mesh.cells);
    std::vector<char> outside(static_cast<std::size_t>(bent.mesh.node_count()), 0);
    for (const std::int32_t node : boundary.faces.reshaped()) outside[static_cast<std::size_t>(node)] = 1;
    double inside = 0;
    for (std::ptrdiff_t i = 0; i < bent.mesh.node_count(); ++i)
      if (!outside[static_cast<std::size_t>(i)])
        inside = std::max(inside, found.force.segment<3>(3 * i).cwiseAbs().maxCoeff());
    CHECK(inside < 1e-13 * found.force.cwiseAbs().maxCoeff());
    // The virial: sum f x = int P : F dV.
    const double volume = 0.01 * 0.02 * 0.005;
    const Matrix3 P = F * StretchLaw(bent.tissue.materials[0]).at(F).stress;
    CHECK(close(found.force.dot(as_vector(x)), volume * P.cwiseProduct(F).sum(), 1e-12));
  }
}

TEST_CASE("stretched tissue: mass is that at rest, stress that of Cauchy, K that at its shape") {
  Bent bent(1);
  const Matrix3 F = some_deformation(0.4);
  const Assembler at_rest(bent.mesh);
  const auto mass = at_rest.mass(bent.tissue).values();
  TetMesh mesh = bent.mesh;
  mesh.rest = bent.mesh.points;
  mesh.points = (bent.mesh.points * F.transpose()).eval();
  const Assembler assembler(mesh);
  CHECK(assembler.mass(bent.tissue).values() == mass);
  CHECK(assembler.lumped_mass(bent.tissue) == at_rest.lumped_mass(bent.tissue));
  CHECK(assembler.stiffness(bent.tissue).values() == at_rest.stretched(bent.tissue, mesh.points).slope.values());
  const Matrix3 T = StretchLaw(bent.tissue.materials[0]).at(F).stress;
  const Matrix3 cauchy = F * T * F.transpose() / F.determinant();
  const auto stress = assembler.stress(bent.tissue);
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c) {
    CHECK(close(stress(c, 0), cauchy(0, 0), 1e-9));
    CHECK(close(stress(c, 3), cauchy(0, 1), 1e-9));
    CHECK(close(stress(c, 5), cauchy(2, 0), 1e-9));
  }
}

TEST_CASE("stretched tissue: a cell that is inside out is named") {
  const Bent bent(1);
  Points x = bent.mesh.points;
  x.col(2) *= -1;
  CHECK_THROWS_AS(Assembler(bent.mesh).stretched(bent.tissue, x), CellInverted);
}

// Masses, loads, symmetry, and the affine form of K.
#include <doctest/doctest.h>

#include <Eigen/Dense>

#include "../approx.hpp"
#include "plica/core/error.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::Distorted;
using scenes::Kind;

namespace {

double volume_of(const Block& block) { return block.size[0] * block.size[1] * block.size[2]; }

double sum(const std::vector<double>& values) {
  return Eigen::Map<const Vector>(values.data(), static_cast<std::ptrdiff_t>(values.size())).sum();
}

double relative(const std::vector<double>& a, const std::vector<double>& b) {
  const Eigen::Map<const Vector> x(a.data(), static_cast<std::ptrdiff_t>(a.size()));
  const Eigen::Map<const Vector> y(b.data(), static_cast<std::ptrdiff_t>(b.size()));
  return (x - y).lpNorm<Eigen::Infinity>() / y.lpNorm<Eigen::Infinity>();
}

// Three materials with fibres of their own, dealt out in turn, and a fourth that no cell uses.
Tissue mixed(const TetMesh& mesh) {
  Material soft;
  soft.elasticity = Isotropic{5e3, 0.4};
  soft.viscosity = 0.4;
  Tissue tissue{{scenes::oblique(), soft, scenes::transverse(1e3, 0.66, 10e3, 0.66, 10e3), soft},
                {"ligament", "body", "cover", "spare"},
                Indices(mesh.cell_count())};
  std::get<TransverselyIsotropic>(tissue.materials[2].elasticity).mu = 1e3 / 1.66;
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c)
    tissue.cell_material[c] = static_cast<std::int32_t>(c % 3);
  return tissue;
}

std::string refusal(const Tissue& tissue, const TetMesh& mesh) {
  try {
    tissue.validate(mesh);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("the pattern couples the nodes of each cell, ascending, and no others") {
  for (const Kind kind : {Kind::linear, Kind::straight}) {
    const Distorted scene(kind);
    const Pattern pattern = Assembler(scene.mesh).pattern();
    const auto n = static_cast<int>(scene.mesh.node_count());
    Eigen::MatrixXi expected = Eigen::MatrixXi::Zero(n, n), found = expected;
    for (std::ptrdiff_t c = 0; c < scene.mesh.cell_count(); ++c) {
      for (const auto i : scene.mesh.cells.row(c)) {
        for (const auto j : scene.mesh.cells.row(c)) expected(i, j) = 1;
      }
    }
    REQUIRE(pattern->rows() == n);
    for (int i = 0; i < n; ++i) {
      const auto begin = pattern->row_start[static_cast<std::size_t>(i)];
      const auto end = pattern->row_start[static_cast<std::size_t>(i) + 1];
      for (auto k = begin; k < end; ++k) {
        ++found(i, pattern->column[static_cast<std::size_t>(k)]);
        if (k > begin)
          CHECK(pattern->column[static_cast<std::size_t>(k - 1)] < pattern->column[static_cast<std::size_t>(k)]);
      }
    }
    CHECK((found - expected).cwiseAbs().maxCoeff() == 0);
  }
}

TEST_CASE("consistent and lumped mass sum to density times volume and are positive") {
  for (const Kind kind : scenes::kinds) {
    CAPTURE(static_cast<int>(kind));
    const Distorted scene(kind);
    const Assembler assembler(scene.mesh);
    const Tissue tissue = scenes::uniform(scene.mesh, scenes::oblique());
    const double total = 1040 * volume_of(scene.block);
    const NodalMatrix M = assembler.mass(tissue);
    const Vector lumped = assembler.lumped_mass(tissue);
    // Moved inner nodes leave the volume of the box as it was; a curved jacobian is integrated exactly.
    CHECK(sum(M.values()) == approx(total).epsilon(1e-13));
    CHECK(lumped.sum() == approx(total).epsilon(1e-13));
    CHECK(lumped.minCoeff() > 0);
    // Cholesky goes through for a positive definite matrix only.
    CHECK(Eigen::LLT<Eigen::MatrixXd>(M.to_sparse().toDense()).info() == Eigen::Success);
    if (kind == Kind::linear) {
      const Vector rows = M * Vector::Ones(M.rows());
      for (std::ptrdiff_t i = 0; i < lumped.size(); ++i) CHECK(lumped[i] == approx(rows[3 * i]).epsilon(1e-13));
    }
  }
}

TEST_CASE("the consistent mass gives the exact kinetic energy of an affine velocity") {
  for (const Kind kind : scenes::kinds) {
    CAPTURE(static_cast<int>(kind));
    const Distorted scene(kind);
    const NodalMatrix M = Assembler(scene.mesh).mass(scenes::uniform(scene.mesh, scenes::oblique()));
    Vector v = Vector::Zero(M.rows());
    for (std::ptrdiff_t i = 0; i < scene.mesh.node_count(); ++i) v[3 * i] = scene.mesh.points(i, 1);
    const double a = scene.block.corner[1], b = a + scene.block.size[1];
    const double mean_square = (b * b * b - a * a * a) / (3 * (b - a));
    // On curved elements N_a N_b det J has degree 7, beyond the rule: the middles are moved by 4 %,
    // and what is lost of it is below 1e-4.
    const double tolerance = kind == Kind::curved ? 1e-4 : 1e-13;
    CHECK(v.dot(M * v) == approx(1040 * volume_of(scene.block) * mean_square).epsilon(tolerance));
  }
}

TEST_CASE("mass, viscosity and stiffness are symmetric to the last bit") {
  for (const Kind kind : scenes::kinds) {
    CAPTURE(static_cast<int>(kind));
    const Distorted scene(kind);
    const Assembler assembler(scene.mesh);
    const Tissue tissue = mixed(scene.mesh);
    const Eigen::MatrixXd M = assembler.mass(tissue).to_sparse(), C = assembler.viscosity(tissue).to_sparse(),
                          K = assembler.stiffness(tissue).to_sparse();
    for (const Eigen::MatrixXd* A : {&M, &C, &K}) {
      CHECK(A->norm() > 0);
      CHECK((*A - A->transpose()).lpNorm<Eigen::Infinity>() == 0);
    }
  }
}

TEST_CASE("viscosity is eta / 2 (g_a . g_b I + g_b g_a^T) on a linear tetrahedron") {
  TetMesh mesh;
  mesh.points.resize(4, 3);
  mesh.points << 0.1, 0.2, 0, 1.3, 0, 0.1, 0.2, 0.9, -0.1, 0.3, 0.2, 1.1;
  mesh.cells.resize(1, 4);
  mesh.cells << 0, 1, 2, 3;
  const Assembler assembler(mesh);
  const Tissue tissue = scenes::uniform(mesh, scenes::oblique());
  const Eigen::MatrixXd C = assembler.viscosity(tissue).to_sparse();
  Eigen::Matrix4d corners;
  corners << mesh.points, Vector::Ones(4);
  const Eigen::Matrix<double, 4, 3> g = corners.inverse().topRows(3).transpose();
  const double volume = std::abs(corners.determinant()) / 6;
  for (int a = 0; a < 4; ++a) {
    for (int b = 0; b < 4; ++b) {
      const Matrix3 exact =
          volume * 3 / 2 * (g.row(a).dot(g.row(b)) * Matrix3::Identity() + g.row(b).transpose() * g.row(a));
      CHECK((C.block<3, 3>(3 * a, 3 * b) - exact).norm() < 1e-13 * C.norm());
    }
  }
}

TEST_CASE("the affine form equals direct assembly") {
  for (const Kind kind : scenes::kinds) {
    CAPTURE(static_cast<int>(kind));
    const Distorted scene(kind);
    const Assembler assembler(scene.mesh);
    const Tissue tissue = mixed(scene.mesh);
    const AffineStiffness affine(assembler, tissue);
    Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor> coefficients(4, 6);
    Vector viscosities(4);
    for (int g = 0; g < 4; ++g) {
      coefficients.row(g) = stiffness_coefficients(tissue.materials[static_cast<std::size_t>(g)]);
      viscosities[g] = tissue.materials[static_cast<std::size_t>(g)].viscosity;
    }
    CHECK(relative(affine.stiffness(coefficients).values(), assembler.stiffness(tissue).values()) < 1e-12);
    CHECK(relative(affine.viscosity(viscosities).values(), assembler.viscosity(tissue).values()) < 1e-12);
    // A change of one material reaches the matrix.
    coefficients(2, 3) *= 1.01;
    CHECK(relative(affine.stiffness(coefficients).values(), assembler.stiffness(tissue).values()) > 1e-4);
    CHECK_THROWS_AS(affine.stiffness(coefficients.topRows(3)), InvalidInput);
    CHECK_THROWS_AS(affine.viscosity(viscosities.head(3)), InvalidInput);
  }
}

TEST_CASE("the load of gravity is the mass times its acceleration") {
  const Vector3 gravity(0.3, -9.81, 1);
  for (const Kind kind : scenes::kinds) {
    CAPTURE(static_cast<int>(kind));
    const Distorted scene(kind);
    const Assembler assembler(scene.mesh);
    const Tissue tissue = mixed(scene.mesh);
    Vector a(3 * scene.mesh.node_count());
    as_points(a).rowwise() = gravity.transpose();
    const Vector load = assembler.body_force(tissue, gravity);
    CHECK((load - assembler.mass(tissue) * a).norm() < 1e-13 * load.norm());
  }
}

TEST_CASE("a uniform traction has its area as resultant and acts at the centre of the face") {
  const Vector3 traction(30, -800, 5);
  for (const Kind kind : scenes::kinds) {
    CAPTURE(static_cast<int>(kind));
    const Distorted scene(kind);
    const Assembler assembler(scene.mesh);
    const Vector f = assembler.traction(scene.mesh.surface("x_max"), traction);
    const auto nodal = as_points(f);
    const double area = scene.block.size[1] * scene.block.size[2];
    const Vector3 resultant = nodal.colwise().sum();
    CHECK((resultant - area * traction).norm() < 1e-13 * area * traction.norm());
    Vector3 couple = Vector3::Zero(), centre;
    for (std::ptrdiff_t i = 0; i < nodal.rows(); ++i) {
      couple += Vector3(scene.mesh.points.row(i)).cross(Vector3(nodal.row(i)));
    }
    for (int d = 0; d < 3; ++d) {
      const auto s = static_cast<std::size_t>(d);
      centre[d] = scene.block.corner[s] + (d == 0 ? 1 : 0.5) * scene.block.size[s];
    }
    const Vector3 exact = centre.cross(area * traction);
    CHECK((couple - exact).norm() < 1e-13 * exact.norm());
  }
}

TEST_CASE(
    "a constant traction loads the middles of a quadratic face with a third each and its corners not at all") {
  const TetMesh mesh = to_quadratic(block_mesh(Block{}));
  const Faces face = mesh.surface("z_max").topRows(1);
  const Vector f = Assembler(mesh).traction(face, Vector3(0, 0, 60));
  for (int a = 0; a < 6; ++a) {
    const double expected = a < 3 ? 0 : 60 * 0.5 / 3;  // the face is half of a unit square
    CHECK(std::abs(f[3 * face(0, a) + 2] - expected) < 1e-14 * 60);
  }
}

TEST_CASE("traction refuses arrays of another mesh") {
  const TetMesh linear = block_mesh(Block{}), quadratic = to_quadratic(linear);
  const Assembler assembler(quadratic);
  CHECK_THROWS_WITH_AS(assembler.traction(linear.surface("x_min"), Vector3::UnitX()),
                       "traction: columns of faces = 3; must be 6 on this mesh.", InvalidInput);
  Faces outside(1, 6);
  outside << 0, 1, 2, 3, 4, 99;
  CHECK_THROWS_WITH_AS(assembler.traction(outside, Vector3::UnitX()),
                       "traction: faces[0, 5] = 99; must be in [0, 27).", InvalidInput);
}

TEST_CASE("an inverted or bent-through cell is refused with its place") {
  TetMesh mesh = block_mesh(Block{});
  std::swap(mesh.cells(4, 0), mesh.cells(4, 1));
  CHECK_THROWS_WITH_AS(Assembler{mesh},
                       doctest::Contains("Assembler: jacobian of cell 4 = -0.166667 m^3; must be > 0."),
                       InvalidInput);
  mesh = to_quadratic(block_mesh(Block{}));
  mesh.points.row(mesh.cells(2, 4)) = mesh.points.row(mesh.cells(2, 2));
  CHECK_THROWS_WITH_AS(Assembler{mesh}, doctest::Contains("bent too far"), InvalidInput);
  mesh.cells(1, 3) = 27;
  CHECK_THROWS_WITH_AS(Assembler{mesh}, doctest::Contains("Assembler: cells[1, 3] = 27; must be in [0, 27)."),
                       InvalidInput);
}

TEST_CASE("a tissue that does not fit its mesh is refused by name") {
  TetMesh mesh = block_mesh(Block{});
  Tissue tissue = mixed(mesh);
  CHECK(refusal(tissue, mesh) == "");  // "spare" is used by no cell
  tissue.cell_material[5] = -1;
  CHECK(refusal(tissue, mesh) ==
        "Tissue: cell_material[5] = -1; must be in [0, 4). Cell 5 of layer \"body\" has no material.");
  tissue.cell_material[5] = 4;
  CHECK(refusal(tissue, mesh).find("Tissue: cell_material[5] = 4; must be in [0, 4).") == 0);
  tissue = mixed(mesh);
  tissue.cell_material.conservativeResize(3);
  CHECK(refusal(tissue, mesh) == "Tissue: size of cell_material = 3; must be 6, one a cell.");
  tissue = mixed(mesh);
  tissue.names.pop_back();
  CHECK(refusal(tissue, mesh) == "Tissue: number of names = 3; must be 4, one a material.");
  tissue = mixed(mesh);
  tissue.materials[2].density = -1;
  CHECK(refusal(tissue, mesh).find("tissue.cover: density = -1 kg/m^3; must be > 0.") == 0);
  CHECK(refusal(Tissue{}, mesh).find("Tissue: number of materials = 0; must be >= 1.") == 0);
}

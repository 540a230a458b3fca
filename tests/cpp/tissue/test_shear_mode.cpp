// The exact shear mode of a transversely isotropic block, u along the fibre = sin(pi x / (2 D)).
#include <doctest/doctest.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "../approx.hpp"
#include "scenes.hpp"

using namespace plica;

namespace {

constexpr double pi = 3.141592653589793;
constexpr double D = 10e-3, T = 7e-3, L = 4e-3;  // m; the mode does not depend on y (L) and z (T)
constexpr double shear_modulus = 10e3, density = 1040, viscosity = 3;
const double exact_frequency = std::sqrt(shear_modulus / density) / (4 * D);  // 77.5217 Hz

enum class MassKind { consistent, lumped };

struct Mode {
  double frequency;      // Hz
  double overlap;        // with the exact shape, 1 where equal
  double damping_ratio;  // u.Cu / (2 omega u.Mu)
};

// Along the fibre held on x = 0; across it held on x = 0 and on both fibre ends.
std::vector<int> free_unknowns(const TetMesh& mesh) {
  std::vector<int> map(static_cast<std::size_t>(3 * mesh.node_count()), -1);
  int next = 0;
  for (std::ptrdiff_t i = 0; i < mesh.node_count(); ++i) {
    const bool root = mesh.points(i, 0) < 1e-9;
    const bool end = mesh.points(i, 1) < 1e-9 || mesh.points(i, 1) > L - 1e-9;
    for (int d = 0; d < 3; ++d) {
      if (!root && (d == 1 || !end)) map[static_cast<std::size_t>(3 * i + d)] = next++;
    }
  }
  return map;
}

Eigen::SparseMatrix<double> restricted(const SparseMatrix& A, const std::vector<int>& map, int size) {
  std::vector<Eigen::Triplet<double>> kept;
  for (int r = 0; r < A.outerSize(); ++r) {
    for (SparseMatrix::InnerIterator it(A, r); it; ++it) {
      const int i = map[static_cast<std::size_t>(r)], j = map[static_cast<std::size_t>(it.col())];
      if (i >= 0 && j >= 0) kept.emplace_back(i, j, it.value());
    }
  }
  Eigen::SparseMatrix<double> result(size, size);
  result.setFromTriplets(kept.begin(), kept.end());
  return result;
}

// The eigenmode next to the exact frequency, by inverse iteration shifted there.
Mode shear_mode(int order, std::array<int, 3> divisions, MassKind mass = MassKind::consistent) {
  Block block;
  block.size = {D, L, T};
  block.divisions = divisions;
  TetMesh mesh = block_mesh(block);
  if (order == 2) mesh = to_quadratic(mesh);
  Material material = scenes::transverse(20e3, 0.45, 40e3, 0.3, shear_modulus);
  material.density = density;
  material.viscosity = viscosity;
  const Tissue tissue = scenes::uniform(mesh, material);
  const Assembler assembler(mesh);
  const auto map = free_unknowns(mesh);
  const int size = 1 + *std::max_element(map.begin(), map.end());
  const auto K = restricted(assembler.stiffness(tissue).to_sparse(), map, size);
  const auto C = restricted(assembler.viscosity(tissue).to_sparse(), map, size);
  Eigen::SparseMatrix<double> M;
  if (mass == MassKind::consistent) {
    M = restricted(assembler.mass(tissue).to_sparse(), map, size);
  } else {
    const Vector lumped = assembler.lumped_mass(tissue);
    std::vector<Eigen::Triplet<double>> diagonal;
    for (std::size_t i = 0; i < map.size(); ++i) {
      if (map[i] >= 0) diagonal.emplace_back(map[i], map[i], lumped[static_cast<std::ptrdiff_t>(i / 3)]);
    }
    M.resize(size, size);
    M.setFromTriplets(diagonal.begin(), diagonal.end());
  }
  Vector exact = Vector::Zero(size);
  for (std::ptrdiff_t i = 0; i < mesh.node_count(); ++i) {
    const int k = map[static_cast<std::size_t>(3 * i + 1)];
    if (k >= 0) exact[k] = std::sin(pi * mesh.points(i, 0) / (2 * D));
  }
  const double shift = std::pow(2 * pi * exact_frequency, 2);
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> shifted(K - shift * M);
  REQUIRE(shifted.info() == Eigen::Success);
  Vector u = exact;
  for (int i = 0; i < 6; ++i) u = shifted.solve(M * u).normalized();
  const double square = u.dot(K * u) / u.dot(M * u), omega = std::sqrt(square);
  REQUIRE((K * u - square * (M * u)).norm() < 1e-6 * (K * u).norm());
  return {omega / (2 * pi), std::abs(u.dot(M * exact)) / std::sqrt(u.dot(M * u) * exact.dot(M * exact)),
          u.dot(C * u) / (2 * omega * u.dot(M * u))};
}

double error(const Mode& mode) { return mode.frequency / exact_frequency - 1; }

double rate(const Mode& coarse, const Mode& fine) { return std::log2(std::abs(error(coarse) / error(fine))); }

}  // namespace

// Rates on these meshes: 1.95 and 3.84, from below, with 2 and 4 as limits.
TEST_CASE("the shear mode of a linear mesh comes from above with the square of the element size") {
  const Mode coarse = shear_mode(1, {6, 2, 3}), fine = shear_mode(1, {12, 4, 6});
  CHECK(coarse.overlap > 0.99);
  CHECK(fine.overlap > 0.999);
  CHECK(error(fine) > 0);
  CHECK(rate(coarse, fine) == approx(2).epsilon(0.05));
}

TEST_CASE("the shear mode of a quadratic mesh comes from above with the fourth power of the element size") {
  const Mode coarse = shear_mode(2, {3, 1, 2}), fine = shear_mode(2, {6, 2, 4});
  CHECK(coarse.overlap > 0.999);
  CHECK(fine.overlap > 0.99999);
  CHECK(error(fine) > 0);
  CHECK(rate(coarse, fine) == approx(4).epsilon(0.05));
}

TEST_CASE("lumped masses take the shear mode below the exact one and quadratic elements down to second order") {
  for (const int order : {1, 2}) {
    CAPTURE(order);
    const std::array<int, 3> few = order == 1 ? std::array<int, 3>{6, 2, 3} : std::array<int, 3>{3, 1, 2};
    const Mode coarse = shear_mode(order, few, MassKind::lumped);
    const Mode fine = shear_mode(order, {2 * few[0], 2 * few[1], 2 * few[2]}, MassKind::lumped);
    CHECK(error(fine) < 0);
    CHECK(rate(coarse, fine) == approx(2).epsilon(0.05));
  }
}

TEST_CASE("the shear mode is damped by eta omega / (4 mu'), the tensor reading of viscosity") {
  const Mode mode = shear_mode(2, {6, 2, 4});
  const double exact = viscosity * 2 * pi * exact_frequency / (4 * shear_modulus);
  // The discrete mode differs from sin(pi x / (2 D)) by some 1e-3 in strain, its quotients by the square.
  CHECK(mode.damping_ratio == approx(exact).epsilon(1e-5));
}

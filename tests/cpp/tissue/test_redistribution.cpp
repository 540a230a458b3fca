// Mass taken from the nodes of a surface.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "../approx.hpp"
#include "plica/core/error.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::Distorted;
using scenes::Kind;

namespace {

const CellMass mass_kinds[] = {CellMass::consistent, CellMass::lumped};

/// (n, n) kg.
Eigen::MatrixXd dense(const NodalMatrix& M) {
  const NodePattern& pattern = *M.pattern();
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(pattern.rows(), pattern.rows());
  for (std::ptrdiff_t i = 0; i < pattern.rows(); ++i)
    for (std::ptrdiff_t e = pattern.row_start[static_cast<std::size_t>(i)];
         e < pattern.row_start[static_cast<std::size_t>(i) + 1]; ++e)
      m(i, pattern.column[static_cast<std::size_t>(e)]) = M.values()[static_cast<std::size_t>(e)];
  return m;
}

Eigen::MatrixXd mass_before(const Assembler& assembler, const Tissue& tissue, CellMass kind) {
  if (kind == CellMass::consistent) return dense(assembler.mass(tissue));
  return assembler.lumped_mass(tissue).asDiagonal();
}

/// Mass, first and second moments of the nodes [begin, end) about their first node: X^T m X with rows (1, x -
/// x_0).
Eigen::Matrix4d moments(const Eigen::MatrixXd& m, const Points& x, std::ptrdiff_t begin, std::ptrdiff_t end) {
  Eigen::MatrixXd X(end - begin, 4);
  for (std::ptrdiff_t i = begin; i < end; ++i) X.row(i - begin) << 1.0, x.row(i) - x.row(begin);
  return X.transpose() * m.block(begin, begin, end - begin, end - begin) * X;
}

std::vector<char> marked(const TetMesh& mesh, const std::vector<std::string>& sets) {
  std::vector<char> nodes(static_cast<std::size_t>(mesh.node_count()), 0);
  for (const auto& name : sets)
    for (const auto node : mesh.node_set(name)) nodes[static_cast<std::size_t>(node)] = 1;
  return nodes;
}

MassTransfer free_body(const TetMesh& mesh, const std::vector<char>& massless) {
  const auto all = [&](char mark) { return std::vector<char>(static_cast<std::size_t>(mesh.node_count()), mark); };
  return {massless, all(0), all(1)};
}

/// Held where `held` marks it, and by that.
MassTransfer held_body(const std::vector<char>& massless, const std::vector<char>& held) {
  return {massless, held, std::vector<char>(held.size(), 0)};
}

/// Light and heavy cells in turn.
Tissue layered(const TetMesh& mesh) {
  Material light = scenes::oblique(), heavy = light;
  heavy.density = 1700;
  Tissue tissue{{light, heavy}, {"light", "heavy"}, Indices(mesh.cell_count())};
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c)
    tissue.cell_material[c] = static_cast<std::int32_t>(c / 7 % 2);
  return tissue;
}

}  // namespace

TEST_CASE("redistributed mass keeps the ten moments, and no more is left on the surface") {
  for (const Kind kind : scenes::kinds)
    for (const CellMass mass : mass_kinds)
      for (const std::vector<std::string>& sets :
           {std::vector<std::string>{"x_max"}, {"x_max", "y_min"}, {"x_max", "y_min", "z_max"}}) {
        CAPTURE(static_cast<int>(kind));
        CAPTURE(static_cast<int>(mass));
        CAPTURE(sets.size());
        const Distorted scene(kind, 5);
        const Assembler assembler(scene.mesh);
        const Tissue tissue = layered(scene.mesh);
        const std::vector<char> massless = marked(scene.mesh, sets);
        const NodalMatrix moved = assembler.redistributed_mass(tissue, mass, free_body(scene.mesh, massless));
        const Eigen::MatrixXd before = mass_before(assembler, tissue, mass), m = dense(moved);
        const Eigen::Matrix4d expected = moments(before, scene.mesh.points, 0, m.rows()),
                              found = moments(m, scene.mesh.points, 0, m.rows());
        for (int i = 0; i < 4; ++i)
          for (int j = 0; j < 4; ++j) CHECK(found(i, j) == approx(expected(i, j)).epsilon(1e-12));
        CHECK(m == m.transpose());
        CHECK(moved.pattern() == assembler.pattern());
        std::vector<std::ptrdiff_t> inner;
        for (std::ptrdiff_t i = 0; i < m.rows(); ++i) {
          if (massless[static_cast<std::size_t>(i)])
            CHECK(m.row(i).isZero(0));
          else
            inner.push_back(i);
        }
        CHECK(Eigen::LLT<Eigen::MatrixXd>(m(inner, inner)).info() == Eigen::Success);
      }
}

TEST_CASE("every body keeps its own moments, and one that loses nothing keeps its matrix") {
  const auto block = [](double x) { return block_mesh({{x, 0, 0}, {1, 0.3, 0.3}, {6, 2, 2}}); };
  const TetMesh mesh = combine_meshes(combine_meshes(block(0), block(1), "a.", "b."), block(2), "", "c.");
  const Assembler assembler(mesh);
  const std::ptrdiff_t n = mesh.node_count() / 3;
  for (const CellMass kind : mass_kinds) {
    const Tissue tissue = scenes::uniform(mesh, scenes::oblique());
    const Eigen::MatrixXd before = mass_before(assembler, tissue, kind),
                          m = dense(assembler.redistributed_mass(
                              tissue, kind, free_body(mesh, marked(mesh, {"a.x_max", "b.x_min"}))));
    for (std::ptrdiff_t k = 0; k < 3; ++k) {
      const Eigen::Matrix4d expected = moments(before, mesh.points, k * n, (k + 1) * n),
                            found = moments(m, mesh.points, k * n, (k + 1) * n);
      CHECK((found - expected).cwiseAbs().maxCoeff() <= 1e-12 * expected.cwiseAbs().maxCoeff());
    }
    CHECK(m.bottomRightCorner(n, n) == before.bottomRightCorner(n, n));
    CHECK(m.topLeftCorner(n, n) != before.topLeftCorner(n, n));
  }
}

TEST_CASE("a single row of cells keeps its moments although some of them repeat others") {
  for (const CellMass kind : mass_kinds) {
    const TetMesh mesh = block_mesh({{0, 0, 0}, {1, 0.01, 0.01}, {100, 1, 1}});
    const Assembler assembler(mesh);
    const Tissue tissue = scenes::uniform(mesh, scenes::oblique());
    const Eigen::Matrix4d expected =
                              moments(mass_before(assembler, tissue, kind), mesh.points, 0, mesh.node_count()),
                          found = moments(dense(assembler.redistributed_mass(
                                              tissue, kind, free_body(mesh, marked(mesh, {"x_min"})))),
                                          mesh.points, 0, mesh.node_count());
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) CHECK(found(i, j) == approx(expected(i, j)).epsilon(1e-12));
  }
}

TEST_CASE("a held body keeps its moving mass, all of it near where it was") {
  for (const Kind kind : scenes::kinds)
    for (const CellMass mass : mass_kinds)
      for (const std::vector<std::string>& sets :
           {std::vector<std::string>{"x_min"}, {"y_min", "y_max"}, {"x_min", "z_min"}}) {
        CAPTURE(static_cast<int>(kind));
        CAPTURE(static_cast<int>(mass));
        CAPTURE(sets.size());
        const Distorted scene(kind, 5);
        const Assembler assembler(scene.mesh);
        const Tissue tissue = layered(scene.mesh);
        const std::vector<char> held = marked(scene.mesh, sets);
        std::vector<char> massless = marked(scene.mesh, {"x_max"});
        std::vector<std::ptrdiff_t> moving;
        for (std::size_t i = 0; i < held.size(); ++i) {
          if (held[i]) massless[i] = 0;
          if (!held[i]) moving.push_back(static_cast<std::ptrdiff_t>(i));
        }
        const Eigen::MatrixXd before = mass_before(assembler, tissue, mass),
                              m = dense(assembler.redistributed_mass(tissue, mass, held_body(massless, held)));
        CHECK(m(moving, moving).sum() == approx(before(moving, moving).sum()).epsilon(1e-13));
        const double above = scene.block.corner[0] + 0.7 * scene.block.size[0];  // a row of cells further down
        int kept = 0;
        for (std::ptrdiff_t i = 0; i < m.rows(); ++i)
          if (scene.mesh.points(i, 0) < above) {
            CHECK((m.row(i) - before.row(i)).norm() <= 1e-13 * before.row(i).norm());
            ++kept;
          }
        CHECK(kept > 0);
        std::vector<std::ptrdiff_t> inner;
        for (const auto i : moving)
          if (!massless[static_cast<std::size_t>(i)]) inner.push_back(i);
        CHECK(Eigen::LLT<Eigen::MatrixXd>(m(inner, inner)).info() == Eigen::Success);
      }
}

TEST_CASE("a held body of two cells in depth takes the mass of its surface, one of one cell has nothing to") {
  const auto moving_mass = [](int depth) {
    const TetMesh mesh = block_mesh({{0, 0, 0}, {1, 1, 1}, {depth, 3, 3}});
    const Assembler assembler(mesh);
    const Tissue tissue = scenes::uniform(mesh, scenes::oblique());
    const std::vector<char> held = marked(mesh, {"x_max"});
    const auto sum = [&](const Eigen::MatrixXd& m) {
      double moving = 0;
      for (std::ptrdiff_t i = 0; i < m.rows(); ++i)
        for (std::ptrdiff_t j = 0; j < m.cols(); ++j)
          if (!held[static_cast<std::size_t>(i)] && !held[static_cast<std::size_t>(j)]) moving += m(i, j);
      return moving;
    };
    const MassTransfer transfer = held_body(marked(mesh, {"x_min"}), held);
    return std::make_pair(sum(dense(assembler.mass(tissue))),
                          sum(dense(assembler.redistributed_mass(tissue, CellMass::consistent, transfer))));
  };
  const auto [before, after] = moving_mass(2);
  CHECK(after == approx(before).epsilon(1e-13));
  CHECK_THROWS_WITH_AS(moving_mass(1), doctest::Contains("number of moving nodes with mass in the body of node 0"),
                       InvalidInput);
}

TEST_CASE("away from the surface the mass of a bar changes by the square of cell over length") {
  const auto largest_change = [](int n) {
    const TetMesh mesh = block_mesh({{0, 0, 0}, {1, 2.0 / n, 2.0 / n}, {n, 2, 2}});
    const Assembler assembler(mesh);
    const Tissue tissue = scenes::uniform(mesh, scenes::oblique());
    const NodalMatrix moved =
        assembler.redistributed_mass(tissue, CellMass::consistent, free_body(mesh, marked(mesh, {"x_min"})));
    const Vector ones = Vector::Ones(3 * mesh.node_count()), before = assembler.mass(tissue) * ones,
                 after = moved * ones;
    double change = 0;
    for (std::ptrdiff_t i = 0; i < mesh.node_count(); ++i)
      if (mesh.points(i, 0) > 1.5 / n) change = std::max(change, std::abs(after[3 * i] / before[3 * i] - 1));
    return change;
  };
  const double coarse = largest_change(40), fine = largest_change(80);
  CHECK(coarse / fine == approx(4).epsilon(0.2));
}

TEST_CASE("a body too thin to take the mass of its surface is refused by its place") {
  const auto refusal = [](int depth, const std::vector<std::string>& sets) -> std::string {
    const TetMesh mesh = block_mesh({{0, 0, 0}, {1, 1, 1}, {depth, 3, 3}});
    try {
      Assembler(mesh).redistributed_mass(scenes::uniform(mesh, scenes::oblique()), CellMass::consistent,
                                         free_body(mesh, marked(mesh, sets)));
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  CHECK(refusal(1, {"x_min", "x_max"}) ==
        "Contact with redistributed mass: number of moving nodes with mass in the body of node 0, centred at "
        "(0.5, 0.5, "
        "0.5) "
        "m = 0; must be >= 1. Too little of it lies behind its contact surfaces, of 32 nodes: refine it to four "
        "cells "
        "or more in depth, or keep the mass of the surface.");
  CHECK(refusal(1, {"x_min"}).find("error of a moment in the body of node 0") != std::string::npos);
  CHECK(refusal(2, {"x_min"}).find("error of a moment in the body of node 0") != std::string::npos);
  CHECK(refusal(4, {"x_min"}).empty());
}

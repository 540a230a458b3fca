#include "convex_bodies.hpp"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <Eigen/Geometry>

#include "oracle.hpp"
#include "plica/meshing/triangulated_airway.hpp"
#include "scenes.hpp"

namespace convex {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Triangulation_vertex_base_with_info_3<std::int32_t, Kernel>;
using Structure = CGAL::Triangulation_data_structure_3<Vertex, CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, Structure>;

constexpr double radius = 8e-3;  // m

double between(std::mt19937& random, double low, double high) {
  return low + (high - low) * (random() / 4294967296.0);
}

Matrix3 rotation(std::mt19937& random) {
  Eigen::Vector4d q;
  do
    for (int k = 0; k < 4; ++k) q[k] = between(random, -1, 1);
  while (q.norm() > 1 || q.norm() < 0.1);
  q.normalize();
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

/// n points on the unit sphere: a spiral, disturbed.
std::vector<Vector3> shell(std::mt19937& random, int n) {
  const double golden_angle = 2.399963229728653;
  std::vector<Vector3> points;
  for (int k = 0; k < n; ++k) {
    const double z = 1 - (2 * k + 1.0) / n, r = std::sqrt(1 - z * z);
    Vector3 p(r * std::cos(k * golden_angle), r * std::sin(k * golden_angle), z);
    for (int c = 0; c < 3; ++c) p[c] += 0.5 / std::sqrt(n) * between(random, -1, 1);
    points.push_back(p.normalized());
  }
  return points;
}

}  // namespace

TetMesh body(std::mt19937& random) {
  const int n = static_cast<int>(between(random, 40, 91));
  Vector3 half;
  for (int c = 0; c < 3; ++c) half[c] = radius * between(random, 0.6, 1.2);
  std::vector<Vector3> points;
  for (const Vector3& p : shell(random, n)) points.push_back((1 + 0.02 * between(random, -1, 1)) * p);
  for (const Vector3& p : shell(random, n / 3)) points.push_back(0.65 * p);
  for (const Vector3& p : shell(random, n / 8)) points.push_back(0.3 * p);
  const Matrix3 turn = rotation(random), turn_nodes = rotation(random);
  for (Vector3& p : points) p = turn * half.cwiseProduct(turn_nodes * p);

  std::vector<std::pair<Kernel::Point_3, std::int32_t>> places;
  for (std::size_t i = 0; i < points.size(); ++i)
    places.emplace_back(Kernel::Point_3(points[i][0], points[i][1], points[i][2]), static_cast<std::int32_t>(i));
  const Delaunay delaunay(places.begin(), places.end());
  std::vector<std::array<std::int32_t, 4>> tets;
  for (const auto cell : delaunay.finite_cell_handles()) {
    std::array<std::int32_t, 4> tet{};
    for (int k = 0; k < 4; ++k) tet[k] = cell->vertex(k)->info();
    double longest = 0;
    for (int k = 0; k < 4; ++k)
      for (int l = 0; l < k; ++l) longest = std::max(longest, (points[tet[k]] - points[tet[l]]).norm());
    const bool of_hull = std::all_of(tet.begin(), tet.end(), [&](std::int32_t node) { return node < n; });
    const Vector3 o = points[tet[0]];
    const double volume = (points[tet[1]] - o).cross(points[tet[2]] - o).dot(points[tet[3]] - o) / 6;
    if (volume > (of_hull ? 3e-3 : 1e-9) * longest * longest * longest) tets.push_back(tet);
  }
  TetMesh mesh;
  mesh.points.resize(static_cast<std::ptrdiff_t>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) mesh.points.row(static_cast<std::ptrdiff_t>(i)) = points[i];
  mesh.cells.resize(static_cast<std::ptrdiff_t>(tets.size()), 4);
  for (std::size_t t = 0; t < tets.size(); ++t)
    for (int k = 0; k < 4; ++k) mesh.cells(static_cast<std::ptrdiff_t>(t), k) = tets[t][k];
  mesh.cell_layer = mesh.cell_side = Indices::Zero(mesh.cells.rows());
  mesh.layer_names = {"body"};
  mesh.surfaces["skin"] = boundary_of(mesh.cells).faces;
  return mesh;
}

Scene thrown(unsigned seed, double speed, std::array<Cells, 2>& cells) {
  std::mt19937 random(seed);
  const TetMesh a = body(random), b = body(random);
  TetMesh mesh = combine_meshes(a, b, "a.", "b.");
  cells = {mesh.cells.topRows(a.cell_count()), mesh.cells.bottomRows(b.cell_count())};
  const double gap = between(random, 0.05e-3, 0.5e-3), off = 0.35 * radius;
  auto of_b = mesh.points.bottomRows(b.node_count());
  of_b.rowwise() += Eigen::RowVector3d(a.points.col(0).maxCoeff() - b.points.col(0).minCoeff(),
                                       between(random, -off, off), between(random, -off, off));
  const auto overlap = [&] {
    for (std::ptrdiff_t i = 0; i < mesh.node_count(); ++i)
      if (oracle::in_tissue(mesh.points, cells[i < a.node_count() ? 1 : 0], mesh.points.row(i))) return true;
    return false;
  };
  while (!overlap()) of_b.col(0).array() -= 0.1e-3;
  of_b.col(0).array() += 0.1e-3 + gap;

  Scene scene = scenes::tissue_scene(std::move(mesh), 0.3, 0.0);
  scene.velocity = Points::Zero(scene.mesh.node_count(), 3);
  scene.velocity->topRows(a.node_count()).col(0).setConstant(speed / 2);
  scene.velocity->bottomRows(b.node_count()).col(0).setConstant(-speed / 2);
  scene.contact = ContactPart{
      triangulated_airway(scene.mesh.points, scene.mesh.surface("a.skin"), scene.mesh.surface("b.skin")),
      Multipliers{},
      {}};
  return scene;
}

Scene mirrored(unsigned seed, double speed) {
  constexpr double facing = 0.3;  // least cosine
  std::mt19937 random(seed);
  TetMesh a = body(random);
  a.points.col(0).array() -= a.points.col(0).maxCoeff() + 0.05e-3;
  std::vector<std::ptrdiff_t> kept;
  const Faces skin = a.surfaces["skin"];
  for (std::ptrdiff_t f = 0; f < skin.rows(); ++f) {
    const Vector3 p = a.points.row(skin(f, 0)), q = a.points.row(skin(f, 1)), r = a.points.row(skin(f, 2));
    if ((q - p).cross(r - p).normalized()[0] > facing) kept.push_back(f);
  }
  a.surfaces = {{"face", skin(kept, Eigen::all)}};
  TetMesh b = a;
  b.points.col(0) *= -1;
  b.cells.col(1).swap(b.cells.col(2));
  b.surfaces["face"].col(1).swap(b.surfaces["face"].col(2));

  Scene scene = scenes::tissue_scene(combine_meshes(a, b, "a.", "b."), 0.3, 0.0);
  scene.velocity = Points::Zero(scene.mesh.node_count(), 3);
  scene.velocity->topRows(a.node_count()).col(0).setConstant(speed / 2);
  scene.velocity->bottomRows(b.node_count()).col(0).setConstant(-speed / 2);
  scene.contact = scenes::contact_of(scene.mesh, "a.face", "b.face", Multipliers{});
  return scene;
}

}  // namespace convex

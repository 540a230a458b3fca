#include <algorithm>

#include "plica/mesh/larynx_curves.hpp"
#include "plica/mesh/structured.hpp"

namespace plica {

namespace {

/// The whole larynx from its quadrant: nodes vertex by vertex, at each the lines around.
struct Whole {
  const LarynxQuadrant& quadrant;
  int around() const { return 4 * quadrant.lines; }
  std::int32_t node(std::int32_t vertex, int line) const { return vertex * around() + line % around(); }
  int folded(int line) const {
    const int half = 2 * quadrant.lines, in_half = line % half;
    return in_half <= quadrant.lines ? in_half : half - in_half;
  }
  std::int32_t image(std::int32_t node) const { return quadrant.node(node / around(), folded(node % around())); }
  bool left(int line) const { return line > quadrant.lines && line < 3 * quadrant.lines; }
  bool back(int line) const { return line > 2 * quadrant.lines; }
  /// A point of the quadrant brought to where nodes or edges between these two lines are.
  Vector3 mirrored(Vector3 p, int line, int other) const {
    if (left(line) || left(other)) p[0] = -p[0];
    if (back(line) || back(other)) p[1] = -p[1];
    return p;
  }
};

TetMesh mirror(const LarynxQuadrant& q) {
  const Whole whole{q};
  const auto count = static_cast<std::int32_t>(q.section.vertices.size());
  TetMesh mesh;
  mesh.layer_names = {"body", "ligament", "cover"};
  mesh.points.resize(count * whole.around(), 3);
  LarynxMarks marks;
  for (std::int32_t v = 0; v < count; ++v)
    for (int line = 0; line < whole.around(); ++line) {
      const std::int32_t node = whole.node(v, line);
      mesh.points.row(node) = whole.mirrored(q.mesh.points.row(whole.image(node)), line, line);
      marks.airway.push_back(q.section.vertices[v].airway);
      marks.wall.push_back(q.section.vertices[v].wall);
      marks.end.push_back(q.section.vertices[v].end);
    }
  std::vector<std::array<std::int32_t, 4>> cells;
  std::vector<std::int32_t> layer, side;
  for (std::size_t k = 0; k < q.section.triangles.size(); ++k)
    for (int line = 0; line < whole.around(); ++line) {
      const auto& t = q.section.triangles[k];
      std::array<PrismCorner, 6> prism;
      for (int c = 0; c < 3; ++c)
        for (const int up : {0, 1}) {
          const std::int32_t v = t[c == 0 ? 0 : 3 - c];
          prism[c + 3 * up] = {whole.node(v, line + up), q.key(v, whole.folded(line + up))};
        }
      split_prism(prism, cells);
      layer.resize(cells.size(), q.section.layers[k]);
      const bool left = line >= q.lines && line < 3 * q.lines;
      side.resize(cells.size(), static_cast<std::int32_t>(left ? Side::left : Side::right));
    }
  mesh.cells = as_cells(cells);
  mesh.cell_layer = Eigen::Map<const Indices>(layer.data(), static_cast<Eigen::Index>(layer.size()));
  mesh.cell_side = Eigen::Map<const Indices>(side.data(), static_cast<Eigen::Index>(side.size()));
  name_larynx_parts(marks, mesh);
  return mesh;
}

}  // namespace

TetMesh mesh_triangulated(const Larynx::Shape& shape, const Larynx::Triangulated& how) {
  return mirror(larynx_quadrant(shape, how));
}

TetMesh quadratic_mesh_triangulated(const Larynx::Shape& shape, const Larynx::Triangulated& how) {
  const LarynxQuadrant q = larynx_quadrant(shape, how);
  const Whole whole{q};
  const LarynxCurves bent = larynx_curves(q);
  const TetMesh linear = mirror(q);
  const std::vector<Edge> edges = unique_edges(linear.cells);
  TetMesh mesh = to_quadratic(linear);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const auto [a, b] = edges[i];
    const Edge image = edge(whole.image(a), whole.image(b));
    const auto place = std::lower_bound(bent.edges.begin(), bent.edges.end(), image) - bent.edges.begin();
    const Vector3 middle =
        0.5 * (q.mesh.points.row(image[0]) + q.mesh.points.row(image[1])).transpose() + bent.bend[place];
    mesh.points.row(linear.node_count() + static_cast<Eigen::Index>(i)) =
        whole.mirrored(middle, a % whole.around(), b % whole.around());
  }
  return mesh;
}

}  // namespace plica

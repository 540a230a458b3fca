#include "plica/mesh/larynx_quadrant.hpp"

#include <Eigen/Dense>

#include "plica/core/error.hpp"
#include "plica/mesh/smoothing.hpp"
#include "plica/mesh/structured.hpp"

namespace plica {

LarynxQuadrant larynx_quadrant(const Larynx::Shape& shape, const Larynx::Triangulated& how) {
  using Plane = Eigen::Vector2d;
  LarynxQuadrant q{shape, half_section(shape, how), how.around / 4, how.tip_cut, {}};
  const LarynxLayers layers(shape);
  const auto count = static_cast<std::int32_t>(q.section.vertices.size());
  q.mesh.points.resize(count * (q.lines + 1), 3);
  std::vector<Freedom> freedom(q.mesh.points.rows());
  for (std::int32_t v = 0; v < count; ++v)
    for (int line = 0; line <= q.lines; ++line) {
      const SectionVertex& vertex = q.section.vertices[v];
      const Plane inner = q.ellipse(vertex.minor, line), outer = q.cylinder(line);
      const double length = (outer - inner).norm();
      const LayerDepths depths = depths_on_line(layers.at(vertex.z), length);
      const double deep =
          vertex.depth < 1   ? vertex.depth * depths.cover
          : vertex.depth < 2 ? depths.cover + (vertex.depth - 1) * depths.ligament
                             : (depths.cover + depths.ligament) * (3 - vertex.depth) + (vertex.depth - 2) * length;
      const Plane p = vertex.airway ? inner : vertex.wall ? outer : Plane(inner + deep / length * (outer - inner));
      q.mesh.points.row(q.node(v, line)) << p[0], p[1], vertex.z;
      Freedom& own = freedom[q.node(v, line)];
      if (vertex.airway || vertex.layer) continue;
      own.along = {line < q.lines ? 1.0 : 0.0, line > 0 ? 1.0 : 0.0, vertex.end ? 0.0 : 1.0};
      if (vertex.wall) own.cylinder = shape.radius;
      if (vertex.wall && (line == 0 || line == q.lines)) own.along[0] = own.along[1] = 0;
    }
  std::vector<std::array<std::int32_t, 4>> cells;
  for (const auto& t : q.section.triangles)
    for (int line = 0; line < q.lines; ++line) {
      std::array<PrismCorner, 6> prism;
      // x right, z up, y away from who looks: seen from larger y the triangle runs clockwise.
      for (int k = 0; k < 3; ++k)
        for (const int up : {0, 1})
          prism[k + 3 * up] = {q.node(t[k == 0 ? 0 : 3 - k], line + up), q.key(t[k == 0 ? 0 : 3 - k], line + up)};
      split_prism(prism, cells);
    }
  q.mesh.cells = as_cells(cells);
  smooth_mesh(q.mesh.points, q.mesh.cells, freedom, 30);
  Eigen::Index worst;
  const double volume = signed_volumes(q.mesh.points, q.mesh.cells).minCoeff(&worst);
  if (!(volume > 0))
    throw InvalidInput("larynx_mesh", "least volume of a tetrahedron", volume, "m^3",
                       "> 0 (at z = " + number_text(q.mesh.points(q.mesh.cells(worst, 0), 2)) + " m)",
                       "Take a smaller size or more lines around.");
  return q;
}

}  // namespace plica

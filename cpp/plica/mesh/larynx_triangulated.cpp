#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "plica/core/error.hpp"
#include "plica/mesh/edges.hpp"
#include "plica/mesh/jacobian.hpp"
#include "plica/mesh/larynx_parts.hpp"
#include "plica/mesh/smoothing.hpp"
#include "plica/mesh/structured.hpp"
#include "plica/mesh/triangulation.hpp"

namespace plica {

namespace {

using Plane = Eigen::Vector2d;

/// Where a vertex of the half section lies; points are (x, z).
struct Vertex {
  double z, minor;
  double depth;  // 0 airway, 1 cover | ligament, 2 ligament | body, 3 wall; linear in between
  bool airway, wall, end, layer;
};

struct HalfSection {
  std::vector<Vertex> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;  // counter-clockwise seen against y
  std::vector<std::int32_t> layers;                    // of the triangles: 0 body, 1 ligament, 2 cover
  std::vector<Edge> airway;                            // its edges on the profile, ascending
};

/// How deep cover and ligament are on a line of that length.
LayerDepths on_line(const LayerDepths& depths, double length) {
  return {std::min(depths.cover, 0.3 * length), std::min(depths.ligament, 0.3 * length)};
}

class Sectioner {
 public:
  Sectioner(const Larynx::Shape& shape, const Larynx::Triangulated& how)
      : shape_(shape), how_(how), layers_(shape) {
    const auto& s = shape.sections;
    low_ = s[shape.layers_from_section].z;
    high_ = s[shape.layers_to_section].z;
  }

  HalfSection make() {
    draw();
    outline_.inside = [&](const Plane& p) { return p[0] > minor_at(shape_, p[1]) && p[0] < shape_.radius; };
    outline_.size = [&](const Plane& p) { return size(p); };
    const Triangulation made = triangulate(outline_);
    HalfSection section;
    for (std::size_t v = 0; v < made.points.size(); ++v) section.vertices.push_back(vertex(made.points[v], v));
    section.triangles = made.triangles;
    for (const auto& t : made.triangles) section.layers.push_back(layer(made, t));
    section.airway = airway_;
    std::sort(section.airway.begin(), section.airway.end());
    return section;
  }

 private:
  /// Wanted length of edges: least between the ends of the layers, on the surface.
  double size(const Plane& p) const {
    double near = std::numeric_limits<double>::infinity();
    const auto& s = shape_.sections;
    for (int k = shape_.layers_from_section; k < shape_.layers_to_section; ++k) {
      const Plane a(s[k].minor, s[k].z), along = Plane(s[k + 1].minor, s[k + 1].z) - a;
      const double t = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
      near = std::min(near, (p - a - t * along).norm());
    }
    return how_.size + how_.growth * near;
  }

  std::int32_t point(const Plane& p) {
    for (std::size_t i = 0; i < outline_.points.size(); ++i)
      if (outline_.points[i] == p) return static_cast<std::int32_t>(i);
    outline_.points.push_back(p);
    return static_cast<std::int32_t>(outline_.points.size()) - 1;
  }

  /// A straight piece in edges of the wanted sizes; its points, both ends among them.
  std::vector<Plane> divided(const Plane& a, const Plane& b) const {
    constexpr int samples = 64;
    std::vector<double> passed = {0};  // edges up to there
    for (int k = 0; k < samples; ++k)
      passed.push_back(passed.back() + (b - a).norm() / samples / size(a + (k + 0.5) / samples * (b - a)));
    const int count = std::max(1, static_cast<int>(std::round(passed.back())));
    std::vector<Plane> points = {a};
    for (int i = 1; i < count; ++i) {
      const double wanted = passed.back() * i / count;
      int k = 0;
      while (passed[k + 1] < wanted) ++k;
      const double f = (k + (wanted - passed[k]) / (passed[k + 1] - passed[k])) / samples;
      const auto mix = [f](double p, double q) { return p == q ? p : (1 - f) * p + f * q; };  // exact on the wall
      points.emplace_back(mix(a[0], b[0]), mix(a[1], b[1]));
    }
    points.push_back(b);
    return points;
  }

  /// Draws straight pieces through the points; what is drawn: the numbers of all points in order.
  std::vector<std::int32_t> draw(const std::vector<Plane>& through) {
    std::vector<std::int32_t> drawn;
    for (std::size_t k = 0; k + 1 < through.size(); ++k) {
      const std::vector<Plane> points = divided(through[k], through[k + 1]);
      for (std::size_t i = k == 0 ? 0 : 1; i < points.size(); ++i) drawn.push_back(point(points[i]));
    }
    outline_.lines.push_back(drawn);
    return drawn;
  }

  Plane layer_point(int layer, double z) const {
    const double minor = minor_at(shape_, z);
    const LayerDepths depths = on_line(layers_.at(z), shape_.radius - minor);
    return {minor + (layer > 0 ? depths.cover : 0) + (layer > 1 ? depths.ligament : 0), z};
  }

  void draw() {
    const auto& s = shape_.sections;
    std::vector<Plane> profile;
    for (const auto& section : s) profile.emplace_back(section.minor, section.z);
    const std::vector<std::int32_t> airway = draw(profile);
    for (std::size_t i = 0; i + 1 < airway.size(); ++i) airway_.push_back(edge(airway[i], airway[i + 1]));
    airway_points_ = airway;
    // The levels at which the layers end reach the wall: triangles across would turn inside out on lines toward
    // the tips, where the layers take a larger part of the depth.
    const int from = shape_.layers_from_section, to = shape_.layers_to_section,
              last = static_cast<int>(s.size()) - 1;
    for (const int k : std::set<int>{0, from, to, last}) {
      std::vector<Plane> through = {profile[k]};
      const bool layered = k == from || k == to;
      if (layered) through.insert(through.end(), {layer_point(1, s[k].z), layer_point(2, s[k].z)});
      through.emplace_back(shape_.radius, s[k].z);
      for (const std::int32_t p : draw(through))
        if (layered && outline_.points[p][0] <= through[2][0]) layer_points_.push_back(p);
    }
    for (const int layer : {1, 2}) {
      std::vector<Plane> line;
      for (const double z : layers_.bends(layer)) line.push_back(layer_point(layer, z));
      const std::vector<std::int32_t> drawn = draw(line);
      layer_points_.insert(layer_points_.end(), drawn.begin(), drawn.end());
    }
    std::vector<Plane> wall;
    for (const int k : std::set<int>{0, from, to, last}) wall.emplace_back(shape_.radius, s[k].z);
    draw(wall);
  }

  Vertex vertex(const Plane& p, std::size_t number) const {
    const auto& s = shape_.sections;
    Vertex made{};
    made.z = p[1];
    made.airway = std::find(airway_points_.begin(), airway_points_.end(), number) != airway_points_.end();
    made.minor = made.airway ? p[0] : minor_at(shape_, p[1]);
    made.wall = p[0] == shape_.radius;
    made.end = p[1] == s.front().z || p[1] == s.back().z;
    made.layer = std::find(layer_points_.begin(), layer_points_.end(), number) != layer_points_.end();
    const double length = shape_.radius - made.minor, deep = p[0] - made.minor;
    const LayerDepths depths = on_line(layers_.at(p[1]), length);
    const double both = depths.cover + depths.ligament;
    const double depth = deep < depths.cover ? deep / depths.cover
                         : deep < both       ? 1 + (deep - depths.cover) / depths.ligament
                                             : 2 + (deep - both) / (length - both);
    made.depth = made.airway ? 0 : made.wall ? 3 : depth;
    return made;
  }

  std::int32_t layer(const Triangulation& made, const std::array<std::int32_t, 3>& t) const {
    const Plane centre = (made.points[t[0]] + made.points[t[1]] + made.points[t[2]]) / 3;
    if (centre[1] < low_ || centre[1] > high_) return 0;
    if (centre[0] < layer_point(1, centre[1])[0]) return 2;
    return centre[0] < layer_point(2, centre[1])[0] ? 1 : 0;
  }

  const Larynx::Shape& shape_;
  const Larynx::Triangulated& how_;
  LarynxLayers layers_;
  double low_, high_;
  Outline outline_;
  std::vector<Edge> airway_;
  std::vector<std::int32_t> airway_points_, layer_points_;
};

/// One quadrant, x, y >= 0: lines 0 (y = 0) to `lines` (the tip), a node at each vertex and line.
struct Quadrant {
  const Larynx::Shape& shape;
  HalfSection section;
  int lines;
  TetMesh mesh;  // points and cells

  std::int32_t node(std::int32_t vertex, int line) const { return vertex * (lines + 1) + line; }
  int line(std::int32_t node) const { return node % (lines + 1); }
  const Vertex& vertex(std::int32_t node) const { return section.vertices[node / (lines + 1)]; }
  /// cos and sin of the angle at which a line, or the middle between two, lies; exact at both ends.
  Plane direction(double line) const {
    if (line == 0) return {1, 0};
    if (line == lines) return {0, 1};
    const double angle = std::acos(0.0) * line / lines;
    return {std::cos(angle), std::sin(angle)};
  }
  Plane ellipse(double minor, double line) const {
    const Plane d = direction(line);
    return {minor * d[0], shape.major * d[1]};
  }
  Plane cylinder(double line) const { return shape.radius * direction(line); }
  /// Quads of even and odd lines are cut by turns: at the lower vertex on even lines.
  std::int64_t key(std::int32_t vertex, int line) const {
    const auto count = static_cast<std::int64_t>(section.vertices.size());
    return line % 2 == 0 ? vertex : 2 * count - vertex;
  }
};

Quadrant place(const Larynx::Shape& shape, const Larynx::Triangulated& how) {
  Quadrant q{shape, Sectioner(shape, how).make(), how.around / 4, {}};
  const LarynxLayers layers(shape);
  const auto count = static_cast<std::int32_t>(q.section.vertices.size());
  q.mesh.points.resize(count * (q.lines + 1), 3);
  std::vector<Freedom> freedom(q.mesh.points.rows());
  for (std::int32_t v = 0; v < count; ++v)
    for (int line = 0; line <= q.lines; ++line) {
      const Vertex& vertex = q.section.vertices[v];
      const Plane inner = q.ellipse(vertex.minor, line), outer = q.cylinder(line);
      const double length = (outer - inner).norm();
      const LayerDepths depths = on_line(layers.at(vertex.z), length);
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
  smooth(q.mesh.points, q.mesh.cells, freedom, 30);
  Eigen::Index worst;
  const double volume = signed_volumes(q.mesh.points, q.mesh.cells).minCoeff(&worst);
  if (!(volume > 0))
    throw InvalidInput("larynx_mesh", "least volume of a tetrahedron", volume, "m^3",
                       "> 0 (at z = " + number(q.mesh.points(q.mesh.cells(worst, 0), 2)) + " m)",
                       "Take a smaller size or more lines around.");
  return q;
}

/// The whole larynx from its quadrant: nodes vertex by vertex, at each the lines around.
struct Whole {
  const Quadrant& quadrant;
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

TetMesh mirror(const Quadrant& q) {
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

/// By how much the middle of each edge of the quadrant is off its chord, in the plane of its height.
struct Curves {
  std::vector<Edge> edges;
  std::vector<Vector3> bend;
  std::vector<char> surface;  // of the airway or of the wall
};

Curves curves(const Quadrant& q) {
  Curves made;
  made.edges = unique_edges(q.mesh.cells);
  for (const auto& [a, b] : made.edges) {
    const Vertex &v = q.vertex(a), &w = q.vertex(b);
    const double la = q.line(a), lb = q.line(b), line = 0.5 * (la + lb), minor = 0.5 * (v.minor + w.minor);
    const std::int32_t va = a / (q.lines + 1), vb = b / (q.lines + 1);
    const bool airway =
        v.airway && w.airway &&
        (va == vb || std::binary_search(q.section.airway.begin(), q.section.airway.end(), edge(va, vb)));
    const bool wall = v.wall && w.wall;
    const Plane chord = 0.5 * (q.mesh.points.row(a) + q.mesh.points.row(b)).head<2>().transpose();
    Plane bend = Plane::Zero();
    if (airway) {
      if (la != lb) bend = q.ellipse(minor, line) - chord;
    } else if (wall) {
      if (la != lb) bend = q.shape.radius / chord.norm() * chord - chord;
    } else if (la != lb) {
      const Plane inner = q.ellipse(minor, line) - 0.5 * (q.ellipse(v.minor, la) + q.ellipse(w.minor, lb));
      const Plane outer = q.cylinder(line) - 0.5 * (q.cylinder(la) + q.cylinder(lb));
      const auto deep = [&](std::int32_t node, const Vertex& own, double at) {
        const Plane from = q.ellipse(own.minor, at), to = q.cylinder(at), along = to - from;
        const Plane p = q.mesh.points.row(node).head<2>();
        return std::clamp((p - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
      };
      const double depth = 0.5 * (deep(a, v, la) + deep(b, w, lb));
      bend = (1 - depth) * inner + depth * outer;
    }
    made.bend.emplace_back(bend[0], bend[1], 0);
    made.surface.push_back(airway || wall);
  }
  return made;
}

/// Straightens sides until no cell's det dx/dxi falls anywhere below `least_jacobian` times the straight cell's:
/// sides inside first.
void straighten(const Quadrant& q, Curves& curves) {
  constexpr double least_jacobian = 0.1;
  TetMesh bare;
  bare.points = q.mesh.points;
  bare.cells = q.mesh.cells;
  TetMesh mesh = to_quadratic(bare);
  const Eigen::Index corners = q.mesh.points.rows();
  const Points straight = mesh.points.bottomRows(mesh.points.rows() - corners);
  for (int pass = 0; pass < 40; ++pass) {
    for (std::size_t i = 0; i < curves.bend.size(); ++i)
      mesh.points.row(corners + static_cast<Eigen::Index>(i)) =
          straight.row(static_cast<Eigen::Index>(i)) + curves.bend[i].transpose();
    const Vector ratio = least_jacobian_ratios(mesh.points, mesh.cells);
    std::vector<char> suffers(curves.bend.size(), 0);
    for (Eigen::Index e = 0; e < mesh.cells.rows(); ++e) {
      if (ratio[e] >= least_jacobian) continue;
      for (int k = 4; k < 10; ++k) suffers[mesh.cells(e, k) - corners] = 1;
    }
    bool changed = false;
    for (std::size_t i = 0; i < suffers.size(); ++i)
      if (suffers[i] && (pass >= 8 || !curves.surface[i])) curves.bend[i] *= pass < 30 ? 0.5 : 0.0;
    for (const char one : suffers) changed |= one;
    if (!changed) return;
  }
}

}  // namespace

TetMesh mesh_triangulated(const Larynx::Shape& shape, const Larynx::Triangulated& how) {
  return mirror(place(shape, how));
}

TetMesh quadratic_mesh_triangulated(const Larynx::Shape& shape, const Larynx::Triangulated& how) {
  const Quadrant q = place(shape, how);
  const Whole whole{q};
  Curves bent = curves(q);
  straighten(q, bent);
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

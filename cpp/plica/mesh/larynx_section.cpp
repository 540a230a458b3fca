#include "plica/mesh/larynx_section.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "plica/mesh/triangulation.hpp"

namespace plica {

namespace {

using Plane = Eigen::Vector2d;

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
    const LayerDepths depths = depths_on_line(layers_.at(z), shape_.radius - minor);
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

  SectionVertex vertex(const Plane& p, std::size_t number) const {
    const auto& s = shape_.sections;
    SectionVertex made{};
    made.z = p[1];
    made.airway = std::find(airway_points_.begin(), airway_points_.end(), number) != airway_points_.end();
    made.minor = made.airway ? p[0] : minor_at(shape_, p[1]);
    made.wall = p[0] == shape_.radius;
    made.end = p[1] == s.front().z || p[1] == s.back().z;
    made.layer = std::find(layer_points_.begin(), layer_points_.end(), number) != layer_points_.end();
    const double length = shape_.radius - made.minor, deep = p[0] - made.minor;
    const LayerDepths depths = depths_on_line(layers_.at(p[1]), length);
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

}  // namespace

LayerDepths depths_on_line(const LayerDepths& depths, double length) {
  const double most = deepest_layer * length;
  return {std::min(depths.cover, most), std::min(depths.ligament, most)};
}

HalfSection half_section(const Larynx::Shape& shape, const Larynx::Triangulated& how) {
  return Sectioner(shape, how).make();
}

}  // namespace plica

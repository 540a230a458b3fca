#include <algorithm>
#include <cmath>

#include "plica/core/error.hpp"
#include "plica/mesh/larynx_parts.hpp"
#include "plica/mesh/larynx_section.hpp"
#include "plica/mesh/structured.hpp"

namespace plica {

namespace {

/// The count + 1 ends, from 0 to 1, of pieces h, h q, h q^2, ... of `length`; q in [1, 3] brings h nearest to
/// `first`.
std::vector<double> graded(int count, double length, double first) {
  const auto sum = [&](double q) {
    double total = 0;
    for (int k = 0; k < count; ++k) total = total * q + 1;
    return total;
  };
  double low = 1, high = 3;
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = 0.5 * (low + high);
    (sum(middle) < length / first ? low : high) = middle;
  }
  const double ratio = sum(1) < length / first ? low : 1;
  std::vector<double> ends = {0};
  double piece = 1 / sum(ratio);
  for (int k = 0; k < count; ++k, piece *= ratio) ends.push_back(ends.back() + piece);
  ends.back() = 1;
  return ends;
}

struct Level {
  double z, minor;
  bool layered;  // the cells above it have a cover and a ligament
};

std::vector<Level> subdivide(const Larynx::Shape& shape, const Larynx::Levels& how) {
  const auto& s = shape.sections;
  const int intervals = static_cast<int>(how.levels.size());
  const auto height = [&](int k) { return s[k + 1].z - s[k].z; };
  std::vector<Level> result;
  for (int k = 0; k < intervals; ++k) {
    const int count = how.levels[k];
    const bool bottom = k == 0 && intervals >= 3, top = k == intervals - 1 && intervals >= 3;
    const int neighbour = bottom ? 1 : top ? k - 1 : k;
    const std::vector<double> ends = graded(count, height(k), height(neighbour) / how.levels[neighbour]);
    for (int i = 0; i < count; ++i) {
      const double f = bottom ? 1 - ends[count - i] : ends[i];
      result.push_back({(1 - f) * s[k].z + f * s[k + 1].z, (1 - f) * s[k].minor + f * s[k + 1].minor,
                        k >= shape.layers_from_section && k < shape.layers_to_section});
    }
  }
  result.push_back({s.back().z, s.back().minor, false});
  return result;
}

/// Where the rings cut a segment of that length from airway to wall, from 0 to 1.
std::vector<double> ring_places(const Larynx::Levels& how, const LayerDepths& depths, double length) {
  const LayerDepths cut = depths_on_line(depths, length);
  const double cover = cut.cover / length, ligament = cut.ligament / length;
  std::vector<double> places;
  for (int k = 0; k < how.cover_rings; ++k) places.push_back(cover * k / how.cover_rings);
  for (int k = 0; k < how.ligament_rings; ++k) places.push_back(cover + ligament * k / how.ligament_rings);
  const double both = cover + ligament, body = 1 - both;
  for (const double end : graded(how.body_rings, body, ligament / how.ligament_rings))
    places.push_back(end < 1 ? both + body * end : 1);
  return places;
}

/// Node numbers, and the fold of the lines into one quadrant: line i, 0 at y = 0, per_quadrant at the tip.
struct Grid {
  int levels, rings, around;  // numbers of node levels, node rings, lines
  int per_quadrant() const { return around / 4; }
  std::int32_t node(int level, int ring, int line) const {
    return (level * rings + ring) * around + line % around;
  }
  int folded(int line) const {
    const int half = 2 * per_quadrant(), in_half = line % half;
    return in_half <= per_quadrant() ? in_half : half - in_half;
  }
  bool left(int line) const { return line % around > per_quadrant() && line % around < 3 * per_quadrant(); }
  bool posterior(int line) const { return line % around > 2 * per_quadrant(); }
  /// Which of the corners a quad is cut at: the same in all four quadrants, by turns in every direction.
  std::int64_t key(int level, int ring, int line) const {
    const std::int64_t turn = (level + ring + line) % 2;
    return ((turn * levels + level) * rings + ring) * around + folded(line);
  }
};

/// One quadrant is computed; the others are its mirror images bit by bit.
Points place_nodes(const Larynx::Shape& shape, const Larynx::Levels& how, const Grid& grid,
                   const std::vector<Level>& levels) {
  const LarynxLayers layers(shape);
  const double half_pi = std::acos(0.0);
  Points points(grid.node(grid.levels - 1, grid.rings - 1, grid.around - 1) + 1, 3);
  for (int level = 0; level < grid.levels; ++level)
    for (int i = 0; i <= grid.per_quadrant(); ++i) {
      const bool tip = i == grid.per_quadrant();
      const double s = static_cast<double>(i) / grid.per_quadrant();
      const double sine = tip ? 1 : std::sin(half_pi * s), cosine = tip ? 0 : std::cos(half_pi * s);
      const double across = 0.5 * (s + sine);  // y / major
      const Eigen::Vector2d inner(levels[level].minor * std::sqrt(1 - across * across), shape.major * across);
      const Eigen::Vector2d outer(shape.radius * cosine, shape.radius * sine);
      const std::vector<double> places = ring_places(how, layers.at(levels[level].z), (outer - inner).norm());
      for (int ring = 0; ring < grid.rings; ++ring) {
        const Eigen::Vector2d p = (1 - places[ring]) * inner + places[ring] * outer;
        for (int line = 0; line < grid.around; ++line)
          if (grid.folded(line) == i)
            points.row(grid.node(level, ring, line)) << (grid.left(line) ? -p[0] : p[0]),
                (grid.posterior(line) ? -p[1] : p[1]), levels[level].z;
      }
    }
  return points;
}

void fill_cells(const Larynx::Levels& how, const Grid& grid, const std::vector<Level>& levels, TetMesh& mesh) {
  std::vector<std::array<std::int32_t, 4>> cells;
  std::vector<std::int32_t> layer, side;
  struct Place {
    int level, line;
  };
  for (int level = 0; level + 1 < grid.levels; ++level)
    for (int ring = 0; ring + 1 < grid.rings; ++ring)
      for (int line = 0; line < grid.around; ++line) {
        const auto prism = [&](Place a, Place b, Place c) {
          const auto corner = [&](Place p, int r) {
            return PrismCorner{grid.node(p.level, r, p.line), grid.key(p.level, r, p.line)};
          };
          split_prism({corner(a, ring), corner(b, ring), corner(c, ring), corner(a, ring + 1), corner(b, ring + 1),
                       corner(c, ring + 1)},
                      cells);
        };
        // Counter-clockwise seen from the wall; the diagonal joins the corners of even level + line.
        const Place a{level, line}, b{level, line + 1}, c{level + 1, line + 1}, d{level + 1, line};
        if ((level + line) % 2 == 0) {
          prism(a, b, c);
          prism(a, c, d);
        } else {
          prism(a, b, d);
          prism(b, c, d);
        }
        const int depth = ring < how.cover_rings ? 2 : ring < how.cover_rings + how.ligament_rings ? 1 : 0;
        const bool left = line >= grid.per_quadrant() && line < 3 * grid.per_quadrant();
        layer.resize(cells.size(), levels[level].layered ? depth : 0);
        side.resize(cells.size(), static_cast<std::int32_t>(left ? Side::left : Side::right));
      }
  mesh.cells = as_cells(cells);
  mesh.cell_layer = Eigen::Map<const Indices>(layer.data(), static_cast<Eigen::Index>(layer.size()));
  mesh.cell_side = Eigen::Map<const Indices>(side.data(), static_cast<Eigen::Index>(side.size()));
}

LarynxMarks marks(const Grid& grid) {
  const std::size_t nodes =
      static_cast<std::size_t>(grid.node(grid.levels - 1, grid.rings - 1, grid.around - 1)) + 1;
  LarynxMarks mark{std::vector<char>(nodes, 0), std::vector<char>(nodes, 0), std::vector<char>(nodes, 0)};
  for (int level = 0; level < grid.levels; ++level)
    for (int ring = 0; ring < grid.rings; ++ring)
      for (int line = 0; line < grid.around; ++line) {
        const std::int32_t node = grid.node(level, ring, line);
        mark.airway[node] = ring == 0;
        mark.wall[node] = ring == grid.rings - 1;
        mark.end[node] = level == 0 || level == grid.levels - 1;
      }
  return mark;
}

}  // namespace

TetMesh mesh_in_levels(const Larynx::Shape& shape, const Larynx::Levels& how) {
  const std::vector<Level> levels = subdivide(shape, how);
  const Grid grid{static_cast<int>(levels.size()), how.cover_rings + how.ligament_rings + how.body_rings + 1,
                  how.around};
  TetMesh mesh;
  mesh.layer_names = {"body", "ligament", "cover"};
  mesh.points = place_nodes(shape, how, grid, levels);
  fill_cells(how, grid, levels, mesh);
  Eigen::Index worst;
  const double least = signed_volumes(mesh.points, mesh.cells).minCoeff(&worst);
  if (!(least > 0))
    throw InvalidInput("larynx_mesh", "least volume of a tetrahedron", least, "m^3",
                       "> 0 (cell " + std::to_string(worst) +
                           " at z = " + number_text(mesh.points(mesh.cells(worst, 0), 2)) + " m)",
                       "Take more levels around that height, or fewer lines around.");
  name_larynx_parts(marks(grid), mesh);
  return mesh;
}

}  // namespace plica

#include "plica/mesh/larynx.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "plica/core/error.hpp"
#include "plica/mesh/structured.hpp"

namespace plica {

namespace {
constexpr double most_nodes = 5e7;  // node numbers and their products fit 32 bits
}

std::vector<Larynx::Section> Larynx::thesis_sections() {
  return {{-2.00e-2, 0.700e-2}, {-0.78e-2, 0.600e-2}, {-0.45e-2, 0.250e-2}, {-0.42e-2, 0.160e-2},
          {-0.35e-2, 0.050e-2}, {-0.31e-2, 0.025e-2}, {-0.04e-2, 0.025e-2}, {-0.02e-2, 0.050e-2},
          {0.03e-2, 0.300e-2},  {0.11e-2, 0.500e-2},  {2.00e-2, 0.700e-2}};
}

Larynx Larynx::coarse() { return {}; }

Larynx Larynx::demo() {
  Larynx larynx;
  larynx.levels = {2, 1, 1, 2, 1, 6, 1, 2, 1, 2};
  larynx.around = 16;
  return larynx;
}

Larynx Larynx::medium() {
  Larynx larynx;
  larynx.levels = {3, 1, 2, 3, 1, 6, 1, 4, 3, 3};
  larynx.around = 24;
  larynx.body_rings = 3;
  return larynx;
}

Larynx Larynx::thesis() {
  Larynx larynx;
  larynx.levels = {7, 1, 4, 5, 1, 8, 1, 9, 7, 8};
  larynx.around = 36;
  larynx.body_rings = 3;
  return larynx;
}

Larynx Larynx::refined(int factor) const {
  if (factor < 1) throw InvalidInput("Larynx::refined", "factor", factor, "", ">= 1");
  double most = std::max({around, cover_rings, ligament_rings, body_rings});
  for (const int count : levels) most = std::max<double>(most, count);
  if (most * factor > most_nodes)
    throw InvalidInput("Larynx::refined", "factor", factor, "",
                       "<= 5e7 / " + number(most) + ", the largest number of levels, lines or rings");
  Larynx larynx = *this;
  for (int& count : larynx.levels) count *= factor;
  larynx.around *= factor;
  larynx.cover_rings *= factor;
  larynx.ligament_rings *= factor;
  larynx.body_rings *= factor;
  return larynx;
}

void Larynx::validate() const {
  const auto positive = [](const std::string& name, double value) {
    if (!(value > 0) || !std::isfinite(value)) throw InvalidInput("Larynx", name, value, "m", "> 0");
  };
  const auto at_least = [](const std::string& name, std::int64_t value, std::int64_t least) {
    if (value < least)
      throw InvalidInput("Larynx", name, static_cast<double>(value), "", ">= " + std::to_string(least));
  };
  const int count = static_cast<int>(sections.size());
  at_least("number of sections", count, 2);
  positive("radius", radius);
  positive("major", major);
  positive("layer_thickness", layer_thickness);
  const std::string inside = "< radius = " + number(radius) + " m";
  const std::string hint = "The airway lies inside the cylinder.";
  if (!(major < radius)) throw InvalidInput("Larynx", "major", major, "m", inside, hint);
  for (int i = 0; i < count; ++i) {
    const std::string name = "sections[" + std::to_string(i) + "]";
    positive(name + ".minor", sections[i].minor);
    if (!(sections[i].minor < radius))
      throw InvalidInput("Larynx", name + ".minor", sections[i].minor, "m", inside, hint);
    if (!std::isfinite(sections[i].z)) throw InvalidInput("Larynx", name + ".z", sections[i].z, "m", "finite");
    if (i > 0 && !(sections[i].z > sections[i - 1].z))
      throw InvalidInput("Larynx", name + ".z", sections[i].z, "m",
                         "> " + number(sections[i - 1].z) + " m, the height of the section before it");
  }
  if (static_cast<int>(levels.size()) != count - 1)
    throw InvalidInput("Larynx", "number of levels", static_cast<double>(levels.size()), "",
                       std::to_string(count - 1), "There is one between any two consecutive sections.");
  for (int k = 0; k < count - 1; ++k) at_least("levels[" + std::to_string(k) + "]", levels[k], 1);
  at_least("sum of levels", std::accumulate(levels.begin(), levels.end(), std::int64_t{0}), 2);
  at_least("layers_from_section", layers_from_section, 0);
  at_least("layers_to_section", layers_to_section, layers_from_section + 1);
  if (layers_to_section > count - 1)
    throw InvalidInput("Larynx", "layers_to_section", layers_to_section, "",
                       "<= " + std::to_string(count - 1) + ", the last section");
  at_least("around", around, 8);
  if (around % 4 != 0)
    throw InvalidInput("Larynx", "around", around, "", "a multiple of 4",
                       "Lines at y = 0 and at both tips need it.");
  at_least("cover_rings", cover_rings, 1);
  at_least("ligament_rings", ligament_rings, 1);
  at_least("body_rings", body_rings, 1);
  double nodes = 1.0 + cover_rings + ligament_rings + body_rings;
  nodes *= around * (1 + std::accumulate(levels.begin(), levels.end(), 0.0));
  if (nodes > most_nodes)
    throw InvalidInput("Larynx", "nodes", nodes, "", "<= 5e7", "Fewer levels, lines or rings are needed.");
}

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

std::vector<Level> subdivide(const Larynx& larynx) {
  const auto& s = larynx.sections;
  const int intervals = static_cast<int>(larynx.levels.size());
  const auto height = [&](int k) { return s[k + 1].z - s[k].z; };
  std::vector<Level> result;
  for (int k = 0; k < intervals; ++k) {
    const int count = larynx.levels[k];
    const bool bottom = k == 0 && intervals >= 3, top = k == intervals - 1 && intervals >= 3;
    const int neighbour = bottom ? 1 : top ? k - 1 : k;
    const std::vector<double> ends = graded(count, height(k), height(neighbour) / larynx.levels[neighbour]);
    for (int i = 0; i < count; ++i) {
      const double f = bottom ? 1 - ends[count - i] : ends[i];
      result.push_back({(1 - f) * s[k].z + f * s[k + 1].z, (1 - f) * s[k].minor + f * s[k + 1].minor,
                        k >= larynx.layers_from_section && k < larynx.layers_to_section});
    }
  }
  result.push_back({s.back().z, s.back().minor, false});
  return result;
}

/// Where the rings cut a segment of that length from airway to wall, from 0 to 1.
std::vector<double> ring_places(const Larynx& larynx, double length) {
  const double layer = std::min(larynx.layer_thickness, 0.3 * length) / length;
  std::vector<double> places;
  for (int k = 0; k < larynx.cover_rings; ++k) places.push_back(layer * k / larynx.cover_rings);
  for (int k = 0; k < larynx.ligament_rings; ++k) places.push_back(layer + layer * k / larynx.ligament_rings);
  const double body = 1 - 2 * layer;
  for (const double end : graded(larynx.body_rings, body, layer / larynx.ligament_rings))
    places.push_back(end < 1 ? 2 * layer + body * end : 1);
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
Points place_nodes(const Larynx& larynx, const Grid& grid, const std::vector<Level>& levels) {
  const double half_pi = std::acos(0.0);
  Points points(grid.node(grid.levels - 1, grid.rings - 1, grid.around - 1) + 1, 3);
  for (int level = 0; level < grid.levels; ++level)
    for (int i = 0; i <= grid.per_quadrant(); ++i) {
      const bool tip = i == grid.per_quadrant();
      const double s = static_cast<double>(i) / grid.per_quadrant();
      const double sine = tip ? 1 : std::sin(half_pi * s), cosine = tip ? 0 : std::cos(half_pi * s);
      const double across = 0.5 * (s + sine);  // y / major
      const Eigen::Vector2d inner(levels[level].minor * std::sqrt(1 - across * across), larynx.major * across);
      const Eigen::Vector2d outer(larynx.radius * cosine, larynx.radius * sine);
      const std::vector<double> places = ring_places(larynx, (outer - inner).norm());
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

void fill_cells(const Larynx& larynx, const Grid& grid, const std::vector<Level>& levels, TetMesh& mesh) {
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
        const int depth = ring < larynx.cover_rings                           ? 2
                          : ring < larynx.cover_rings + larynx.ligament_rings ? 1
                                                                              : 0;
        const bool left = line >= grid.per_quadrant() && line < 3 * grid.per_quadrant();
        layer.resize(cells.size(), levels[level].layered ? depth : 0);
        side.resize(cells.size(), static_cast<std::int32_t>(left ? Side::left : Side::right));
      }
  mesh.cells = as_cells(cells);
  mesh.cell_layer = Eigen::Map<const Indices>(layer.data(), static_cast<Eigen::Index>(layer.size()));
  mesh.cell_side = Eigen::Map<const Indices>(side.data(), static_cast<Eigen::Index>(side.size()));
}

void name_parts(const Grid& grid, TetMesh& mesh) {
  std::vector<char> airway(mesh.node_count(), 0), left = airway, right = airway;
  std::vector<std::int32_t> wall, ends;
  for (int level = 0; level < grid.levels; ++level)
    for (int ring = 0; ring < grid.rings; ++ring)
      for (int line = 0; line < grid.around; ++line) {
        const std::int32_t node = grid.node(level, ring, line);
        if (ring == 0) {
          airway[node] = 1;
          left[node] = mesh.points(node, 0) <= 0;
          right[node] = mesh.points(node, 0) >= 0;
        }
        if (ring == grid.rings - 1) wall.push_back(node);
        if (level == 0 || level == grid.levels - 1) ends.push_back(node);
      }
  const Boundary hull = boundary(mesh.cells);
  mesh.surfaces["airway"] = marked_faces(hull, airway);
  mesh.surfaces["airway_left"] = marked_faces(hull, left);
  mesh.surfaces["airway_right"] = marked_faces(hull, right);
  mesh.node_sets["wall"] = Eigen::Map<const Indices>(wall.data(), static_cast<Eigen::Index>(wall.size()));
  mesh.node_sets["ends"] = Eigen::Map<const Indices>(ends.data(), static_cast<Eigen::Index>(ends.size()));
}

}  // namespace

TetMesh larynx_mesh(const Larynx& larynx) {
  larynx.validate();
  const std::vector<Level> levels = subdivide(larynx);
  const Grid grid{static_cast<int>(levels.size()),
                  larynx.cover_rings + larynx.ligament_rings + larynx.body_rings + 1, larynx.around};
  TetMesh mesh;
  mesh.layer_names = {"body", "ligament", "cover"};
  mesh.points = place_nodes(larynx, grid, levels);
  fill_cells(larynx, grid, levels, mesh);
  Eigen::Index worst;
  const double least = signed_volumes(mesh.points, mesh.cells).minCoeff(&worst);
  if (!(least > 0))
    throw InvalidInput(
        "larynx_mesh", "least volume of a tetrahedron", least, "m^3",
        "> 0 (cell " + std::to_string(worst) + " at z = " + number(mesh.points(mesh.cells(worst, 0), 2)) + " m)",
        "Take more levels around that height, or fewer lines around.");
  name_parts(grid, mesh);
  return mesh;
}

}  // namespace plica

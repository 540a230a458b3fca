#include "plica/airflow/sections.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"

namespace plica {
namespace {

/// Where the mid-coronal plane meets the interface: a node (a = b), or the edge a b at a + t (b - a).
struct CutVertex {
  std::int32_t a, b;
  double t;
  double x, z;
};

struct Segment {
  CutVertex low, high;
};

/// The mid-coronal line of one fold, bottom to top.
using Line = std::vector<CutVertex>;

Eigen::AlignedBox3d box_of(const Points& points, const Triangles& triangles) {
  Eigen::AlignedBox3d box;
  for (const auto node : triangles.reshaped()) box.extend(points.row(node).transpose());
  return box;
}

/// Segments of the plane y = middle on the fold of larger and on that of smaller x: outward means toward -x on the
/// former, which tells the folds apart also where they touch. A segment along an edge comes once.
std::array<std::vector<Segment>, 2> cut_coronal(const Points& points, const Triangles& triangles, double middle,
                                                double tolerance) {
  const auto ahead = [&](std::int32_t node) { return points(node, 1) - middle; };
  std::array<std::map<std::array<std::int32_t, 4>, Segment>, 2> found;
  for (const auto& triangle : triangles.rowwise()) {
    std::array<int, 3> sign;
    for (int c = 0; c < 3; ++c) {
      const double y = ahead(triangle[c]);
      sign[c] = std::abs(y) <= tolerance ? 0 : y > 0 ? 1 : -1;
    }
    std::array<CutVertex, 3> ends;
    int count = 0;
    for (int c = 0; c < 3; ++c) {
      const int d = (c + 1) % 3;
      if (sign[c] == 0)
        ends[count++] = {triangle[c], triangle[c], 0, points(triangle[c], 0), points(triangle[c], 2)};
      else if (sign[c] * sign[d] < 0) {
        const auto a = std::min(triangle[c], triangle[d]), b = std::max(triangle[c], triangle[d]);
        const double t = ahead(a) / (ahead(a) - ahead(b));
        ends[count++] = {a, b, t, points(a, 0) + t * (points(b, 0) - points(a, 0)),
                         points(a, 2) + t * (points(b, 2) - points(a, 2))};
      }
    }
    if (count < 2) continue;
    auto [low, high, rest] = ends;
    if (low.z > high.z) std::swap(low, high);
    if (count == 3 || high.z - low.z <= tolerance)
      throw InvalidInput("Airflow: interface at y = " + number_text(middle) + " m, (x, z) = (" +
                         number_text(low.x) + ", " + number_text(low.z) +
                         ") m; must have one x at each height on each fold, but runs level there. "
                         "Does the surface hold more than the walls of the airway?");
    const Vector3 u = points.row(triangle[1]) - points.row(triangle[0]),
                  v = points.row(triangle[2]) - points.row(triangle[0]);
    const double normal_x = u[1] * v[2] - u[2] * v[1];
    found[normal_x < 0 ? 0 : 1].insert({{low.a, low.b, high.a, high.b}, {low, high}});
  }
  std::array<std::vector<Segment>, 2> sides;
  for (int side = 0; side < 2; ++side)
    for (const auto& entry : found[side]) sides[side].push_back(entry.second);
  return sides;
}

Line join(std::vector<Segment> segments, const std::string& side, double middle, double tolerance) {
  if (segments.empty())
    throw InvalidInput("Airflow: interface toward " + side +
                       " x; must cross its mid-coronal plane y = " + number_text(middle) +
                       " m. Are the anteroposterior axis y and the outward "
                       "direction of the surface right?");
  std::sort(segments.begin(), segments.end(), [](const auto& p, const auto& q) { return p.low.z < q.low.z; });
  Line line{segments[0].low};
  for (const auto& segment : segments) {
    const auto& end = line.back();
    if (std::abs(segment.low.z - end.z) > tolerance || std::abs(segment.low.x - end.x) > tolerance)
      throw InvalidInput("Airflow: interface toward " + side + " x at y = " + number_text(middle) +
                         " m, (x, z) = (" + number_text(segment.low.x) + ", " + number_text(segment.low.z) +
                         ") m; must have one x at each height, " +
                         (segment.low.z < end.z + tolerance ? "has several" : "has none just below") +
                         ". The flow needs folds without overhang.");
    line.push_back(segment.high);
  }
  return line;
}

void add(MaterialPoint& point, const CutVertex& vertex, double weight) {
  const std::array<std::pair<std::int32_t, double>, 2> parts{
      {{vertex.a, weight * (1 - vertex.t)}, {vertex.b, weight * vertex.t}}};
  for (const auto& [node, part] : parts) {
    if (part == 0) continue;
    const auto at = std::find(point.nodes.begin(), point.nodes.end(), node);
    if (at != point.nodes.end())
      point.weights[at - point.nodes.begin()] += part;
    else {
      point.nodes.push_back(node);
      point.weights.push_back(part);
    }
  }
}

/// The point of the line at a height within its range; its vertex where one is that near.
MaterialPoint point_at(const Line& line, double height, double tolerance) {
  MaterialPoint point;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (std::abs(line[i].z - height) <= tolerance) {
      add(point, line[i], 1);
      break;
    }
    if (line[i].z > height) {
      const double t = (height - line[i - 1].z) / (line[i].z - line[i - 1].z);
      add(point, line[i - 1], 1 - t);
      add(point, line[i], t);
      break;
    }
  }
  return point;
}

/// Least and largest y of the interface at each of ascending heights.
struct Depths {
  Vector low, high;

  Depths(const Points& points, const Triangles& triangles, const Vector& heights, double tolerance)
      : low(Vector::Constant(heights.size(), std::numeric_limits<double>::infinity())), high(-low) {
    for (const auto& triangle : triangles.rowwise())
      for (int c = 0; c < 3; ++c) {
        const auto a = triangle[c], b = triangle[(c + 1) % 3];
        const auto [bottom, top] = std::minmax({points(a, 2), points(b, 2)});
        const double lowest = bottom - 2 * tolerance, highest = top + 2 * tolerance;  // beyond round-off
        for (auto i = std::lower_bound(heights.begin(), heights.end(), lowest) - heights.begin();
             i < heights.size() && heights[i] <= highest; ++i) {
          const double below = points(a, 2) - heights[i], above = points(b, 2) - heights[i];
          if (std::abs(below) <= tolerance)
            include(i, points(a, 1));
          else if (below * above < 0)
            include(i, points(a, 1) + below / (below - above) * (points(b, 1) - points(a, 1)));
        }
      }
  }

 private:
  void include(std::ptrdiff_t i, double y) {
    low[i] = std::min(low[i], y);
    high[i] = std::max(high[i], y);
  }
};

/// How many more cells at the nodes of the line are of the right fold than of the left one.
int right_cells(const TetMesh& mesh, const Line& line) {
  std::vector<char> on_line(static_cast<std::size_t>(mesh.node_count()), 0);
  for (const auto& vertex : line) on_line[vertex.a] = on_line[vertex.b] = 1;
  int more = 0;
  for (std::ptrdiff_t e = 0; e < mesh.cell_side.size(); ++e) {
    const auto side = static_cast<Side>(mesh.cell_side[e]);
    const auto corners = mesh.cells.row(e).head<4>();
    if (side != Side::none && std::any_of(corners.begin(), corners.end(), [&](auto n) { return on_line[n] != 0; }))
      more += side == Side::right ? 1 : -1;
  }
  return more;
}

}  // namespace

Vector3 MaterialPoint::at(const Points& x) const {
  require_size("MaterialPoint", "weights", static_cast<std::ptrdiff_t>(weights.size()),
               static_cast<std::ptrdiff_t>(nodes.size()));
  require_indices("MaterialPoint", "node", nodes, x.rows());
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < nodes.size(); ++i) sum += weights[i] * x.row(nodes[i]).transpose();
  return sum;
}

Vector Sections::widths(const Points& x) const {
  require_size("Sections", "right", static_cast<std::ptrdiff_t>(right.size()), count());
  require_size("Sections", "left", static_cast<std::ptrdiff_t>(left.size()), count());
  Vector widths(count());
  for (std::ptrdiff_t i = 0; i < count(); ++i) widths[i] = toward_right * (right[i].at(x)[0] - left[i].at(x)[0]);
  return widths;
}

namespace {

/// Both mid-coronal lines, and what sections at their heights need.
struct Coronal {
  Triangles triangles;
  double same_height, on_plane;  // m, tolerances
  Line right, left;
  double toward_right = 1;

  Coronal(const TetMesh& mesh, const Faces& surface) : triangles(flat_triangles(surface)) {
    require_indices("Airflow", "node of the surface", surface, mesh.node_count());
    const Eigen::AlignedBox3d box = box_of(mesh.points, triangles);
    const double extent = box.diagonal().norm(), middle = box.center()[1];
    same_height = 1e-6 * extent;
    on_plane = 1e-9 * extent;
    auto sides = cut_coronal(mesh.points, triangles, middle, on_plane);
    right = join(std::move(sides[0]), "larger", middle, same_height);
    left = join(std::move(sides[1]), "smaller", middle, same_height);
    if (right_cells(mesh, right) < right_cells(mesh, left)) {
      std::swap(right, left);
      toward_right = -1;
    }
    if (lowest() - same_height > highest() + same_height)
      throw InvalidInput("Airflow", "lowest height of one fold", lowest(), "m",
                         "<= " + number_text(highest()) + ", the highest of the other",
                         "The folds share no height.");
  }
  double lowest() const { return std::max(right.front().z, left.front().z); }
  double highest() const { return std::min(right.back().z, left.back().z); }

  Sections at(const TetMesh& mesh, const std::vector<double>& heights) const {
    Sections sections;
    sections.toward_right = toward_right;
    sections.height = Eigen::Map<const Vector>(heights.data(), static_cast<std::ptrdiff_t>(heights.size()));
    const Depths depths(mesh.points, triangles, sections.height, on_plane);
    sections.major = (depths.high - depths.low) / 2;
    sections.middle = (depths.high + depths.low) / 2;
    for (std::ptrdiff_t i = 0; i < sections.count(); ++i) {
      sections.right.push_back(point_at(right, sections.height[i], same_height));
      sections.left.push_back(point_at(left, sections.height[i], same_height));
    }
    const double inside_out = sections.widths(mesh.points).minCoeff();
    if (inside_out < -same_height)
      throw InvalidInput("Airflow", "least width of the airway at rest", inside_out, "m", ">= 0",
                         "Is the surface outward, into the air?");
    return sections;
  }
};

/// Where the lines have vertices, within the heights that both have; heights closer than same_height are one.
std::vector<double> vertex_heights(const Coronal& coronal) {
  std::vector<double> candidates, heights;
  for (const auto* line : {&coronal.right, &coronal.left})
    for (const auto& vertex : *line)
      if (vertex.z >= coronal.lowest() - coronal.same_height &&
          vertex.z <= coronal.highest() + coronal.same_height)
        candidates.push_back(vertex.z);
  std::sort(candidates.begin(), candidates.end());
  for (const double z : candidates)
    if (heights.empty() || z - heights.back() > coronal.same_height) heights.push_back(z);
  return heights;
}

/// Moves to each vertex of the lines the height that is nearest to it, the first and the last height apart. Of
/// several vertices with the same nearest height the nearest one has it.
void move_to_vertices(const Coronal& coronal, std::vector<double>& heights) {
  std::vector<double> vertex(heights.size(), std::numeric_limits<double>::infinity());
  for (const double z : vertex_heights(coronal)) {
    const auto above = std::lower_bound(heights.begin(), heights.end(), z);
    if (above == heights.begin() || above == heights.end()) continue;
    const std::size_t i = (z - *(above - 1) < *above - z ? above - 1 : above) - heights.begin();
    if (i == 0 || i + 1 == heights.size()) continue;
    if (std::abs(z - heights[i]) < std::abs(vertex[i] - heights[i])) vertex[i] = z;
  }
  for (std::size_t i = 0; i < heights.size(); ++i)
    if (std::isfinite(vertex[i])) heights[i] = vertex[i];
}

/// Heights between which planes cut all of the airway. At rest its lower and its upper rim are level, and the ends
/// are inset a little; at a posture they bulge.
std::pair<double, double> whole_heights(const TetMesh& mesh, const Faces& surface, const Coronal& coronal) {
  const double inset = 1e-4 * (coronal.highest() - coronal.lowest());
  double low = coronal.lowest(), high = coronal.highest();
  if (mesh.stretched()) {
    const Vector z = mesh.rest.col(2)(surface.reshaped());
    const double lowest = z.minCoeff() + coronal.same_height, highest = z.maxCoeff() - coronal.same_height;
    for (const std::int32_t node : surface.reshaped()) {
      if (mesh.rest(node, 2) <= lowest) low = std::max(low, mesh.points(node, 2));
      if (mesh.rest(node, 2) >= highest) high = std::min(high, mesh.points(node, 2));
    }
  }
  return {low + inset, high - inset};
}

}  // namespace

Sections level_sections(const TetMesh& mesh, const Faces& surface) {
  const Coronal coronal(mesh, surface);
  return coronal.at(mesh, vertex_heights(coronal));
}

Sections graded_sections(const TetMesh& mesh, const Faces& surface, int count) {
  require_at_least("graded_sections", "the sections", count, 2);
  const Coronal coronal(mesh, surface);
  const auto [low, high] = whole_heights(mesh, surface, coronal);
  if (!(high - low > count * coronal.same_height))
    throw InvalidInput(
        "Airflow", "height that both folds share", high - low, "m",
        "> " + number_text(count * coronal.same_height) + " for " + std::to_string(count) + " sections");
  const int samples = 20 * count + 1;
  const Vector z = Vector::LinSpaced(samples, low, high);
  const Vector area = cut_areas(mesh.points, coronal.triangles, z);
  const Depths depths(mesh.points, coronal.triangles, z, coronal.on_plane);
  Vector below = Vector::Zero(samples);  // sections up to z, but for a factor
  double last = 0;
  for (int k = 0; k < samples; ++k) {
    const double depth = depths.high[k] - depths.low[k];
    const double density = 1 / (std::max(area[k], 0.0) / (depth * depth) + 0.05);
    if (k > 0) below[k] = below[k - 1] + (last + density) / 2;
    last = density;
  }
  std::vector<double> heights;
  for (int i = 0, k = 0; i < count; ++i) {
    const double wanted = below[samples - 1] * i / (count - 1);
    while (k + 2 < samples && below[k + 1] < wanted) ++k;
    heights.push_back(z[k] + (wanted - below[k]) / (below[k + 1] - below[k]) * (z[k + 1] - z[k]));
  }
  move_to_vertices(coronal, heights);
  return coronal.at(mesh, heights);
}

Vector cut_areas(const Points& x, const Triangles& surface, const Vector& heights) {
  require_indices("cut_areas", "node of the surface", surface, x.rows());
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto node : surface.reshaped()) low = std::min(low, x(node, 2)), high = std::max(high, x(node, 2));
  const double aside = origin_near(x)[0];  // of a mesh far away, whose x would drown the area in round-off
  Vector areas = Vector::Zero(heights.size());
  const double *first = heights.data(), *last = first + heights.size();
  for (const auto& triangle : surface.rowwise()) {
    const auto [bottom, top] = std::minmax({x(triangle[0], 2), x(triangle[1], 2), x(triangle[2], 2)});
    for (const double* plane = std::lower_bound(first, last, bottom); plane != last && *plane <= top; ++plane) {
      const double height = *plane;
      // A node in the plane counts as below it in the lower half of the interface and as above it in the upper
      // half, so that the plane also meets triangles where it passes through the lowest or the highest nodes.
      const bool lower_half = height <= (low + high) / 2;
      const auto above = [&](std::int32_t node) {
        return lower_half ? x(node, 2) > height : x(node, 2) >= height;
      };
      double from[2] = {0, 0}, to[2] = {0, 0};  // counter-clockwise around the air, seen from above
      for (int c = 0; c < 3; ++c) {
        const auto a = triangle[c], b = triangle[(c + 1) % 3];
        if (above(a) == above(b)) continue;
        const double t = (height - x(a, 2)) / (x(b, 2) - x(a, 2));
        double* end = above(b) ? from : to;
        for (int k = 0; k < 2; ++k) end[k] = (1 - t) * x(a, k) + t * x(b, k);
      }
      areas[plane - first] += ((from[0] + to[0]) / 2 - aside) * (to[1] - from[1]);
    }
  }
  return areas;
}

double cut_area(const Points& x, const Triangles& surface, double height) {
  return cut_areas(x, surface, Vector::Constant(1, height))[0];
}

}  // namespace plica

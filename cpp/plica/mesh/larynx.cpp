#include "plica/mesh/larynx.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "plica/core/error.hpp"
#include "plica/mesh/larynx_parts.hpp"
#include "plica/mesh/structured.hpp"

namespace plica {

namespace {
constexpr double most_nodes = 5e7;                             // node numbers and their products fit 32 bits
constexpr double most_section_points = 1e4, most_lines = 1e3;  // of a triangulated section: seconds
}  // namespace

std::vector<Larynx::Section> Larynx::thesis_sections() {
  return {{-2.00e-2, 0.700e-2}, {-0.78e-2, 0.600e-2}, {-0.45e-2, 0.250e-2}, {-0.42e-2, 0.160e-2},
          {-0.35e-2, 0.050e-2}, {-0.31e-2, 0.025e-2}, {-0.04e-2, 0.025e-2}, {-0.02e-2, 0.050e-2},
          {0.03e-2, 0.300e-2},  {0.11e-2, 0.500e-2},  {2.00e-2, 0.700e-2}};
}

namespace {

Larynx triangulated(double size, double growth, int around) {
  Larynx larynx;
  larynx.meshed = Larynx::Triangulated{size, growth, around};
  return larynx;
}

Larynx in_levels(std::vector<int> levels, int around, int body_rings) {
  Larynx larynx;
  larynx.meshed = Larynx::Levels{std::move(levels), around, 1, 1, body_rings};
  return larynx;
}

}  // namespace

Larynx Larynx::coarse() { return {}; }
Larynx Larynx::demo() { return triangulated(0.4e-3, 0.46, 20); }
Larynx Larynx::fine() { return triangulated(0.27e-3, 0.3, 20); }
Larynx Larynx::finest() { return triangulated(0.2e-3, 0.24, 24); }
Larynx Larynx::thesis() { return in_levels({7, 1, 4, 5, 1, 8, 1, 9, 7, 8}, 36, 3); }
Larynx Larynx::thesis_coarse() { return in_levels({2, 1, 1, 1, 1, 4, 1, 1, 1, 1}, 12, 2); }
Larynx Larynx::thesis_demo() { return in_levels({2, 1, 1, 2, 1, 6, 1, 2, 1, 2}, 16, 2); }
Larynx Larynx::thesis_medium() { return in_levels({3, 1, 2, 3, 1, 6, 1, 4, 3, 3}, 24, 3); }

namespace {

Larynx::Triangulated refined(const Larynx::Triangulated& how, double factor) {
  return {how.size / factor, how.growth / factor, 4 * static_cast<int>(std::round(how.around * factor / 4)),
          how.tip_cut};
}

Larynx::Levels refined(Larynx::Levels how, double factor) {
  const auto more = [&](int& count) { count = static_cast<int>(std::round(count * factor)); };
  for (int& count : how.levels) more(count);
  more(how.cover_rings);
  more(how.ligament_rings);
  more(how.body_rings);
  how.around = 4 * static_cast<int>(std::round(how.around * factor / 4));
  return how;
}

double most_counted(const Larynx::Triangulated& how) { return how.around; }

double most_counted(const Larynx::Levels& how) {
  double most = std::max({how.around, how.cover_rings, how.ligament_rings, how.body_rings});
  for (const int count : how.levels) most = std::max<double>(most, count);
  return most;
}

}  // namespace

Larynx Larynx::refined(double factor) const {
  if (!(factor > 0)) throw InvalidInput("Larynx::refined", "factor", factor, "", "> 0");
  const double most = std::visit([](const auto& how) { return most_counted(how); }, meshed);
  if (!(most * factor <= most_nodes))
    throw InvalidInput("Larynx::refined", "factor", factor, "",
                       "<= 5e7 / " + number_text(most) + ", the largest number of levels, lines or rings");
  Larynx larynx = *this;
  larynx.meshed =
      std::visit([&](const auto& how) -> decltype(meshed) { return plica::refined(how, factor); }, meshed);
  return larynx;
}

namespace {

void require_positive(const std::string& name, double value) {
  if (!(value > 0) || !std::isfinite(value)) throw InvalidInput("Larynx", name, value, "m", "> 0");
}

void require_not_negative(const std::string& name, double value) {
  if (!(value >= 0) || !std::isfinite(value))
    throw InvalidInput("Larynx", name, value, "", value < 0 ? ">= 0" : ">= 0 and finite");
}

void require_at_least(const std::string& name, std::int64_t value, std::int64_t least) {
  if (value < least)
    throw InvalidInput("Larynx", name, static_cast<double>(value), "", ">= " + std::to_string(least));
}

void require_lines(int around) {
  require_at_least("around", around, 8);
  if (around % 4 != 0)
    throw InvalidInput("Larynx", "around", around, "", "a multiple of 4",
                       "Lines at y = 0 and at both tips need it.");
}

}  // namespace

void Larynx::Shape::validate() const {
  const int count = static_cast<int>(sections.size());
  require_at_least("number of sections", count, 2);
  require_positive("radius", radius);
  require_positive("major", major);
  require_positive("layer_thickness", layer_thickness);
  if (ligament_thickness) require_positive("ligament_thickness", *ligament_thickness);
  const std::string inside = "< radius = " + number_text(radius) + " m";
  const std::string hint = "The airway lies inside the cylinder.";
  if (!(major < radius)) throw InvalidInput("Larynx", "major", major, "m", inside, hint);
  for (int i = 0; i < count; ++i) {
    const std::string name = "sections[" + std::to_string(i) + "]";
    require_positive(name + ".minor", sections[i].minor);
    if (!(sections[i].minor < radius))
      throw InvalidInput("Larynx", name + ".minor", sections[i].minor, "m", inside, hint);
    if (!std::isfinite(sections[i].z)) throw InvalidInput("Larynx", name + ".z", sections[i].z, "m", "finite");
    if (i > 0 && !(sections[i].z > sections[i - 1].z))
      throw InvalidInput("Larynx", name + ".z", sections[i].z, "m",
                         "> " + number_text(sections[i - 1].z) + " m, the height of the section before it");
  }
  require_at_least("layers_from_section", layers_from_section, 0);
  require_at_least("layers_to_section", layers_to_section, layers_from_section + 1);
  if (layers_to_section > count - 1)
    throw InvalidInput("Larynx", "layers_to_section", layers_to_section, "",
                       "<= " + std::to_string(count - 1) + ", the last section");
}

namespace {

void validate(const Larynx::Shape& shape, const Larynx::Levels& how) {
  const auto& levels = how.levels;
  if (levels.size() + 1 != shape.sections.size())
    throw InvalidInput("Larynx", "number of levels", static_cast<double>(levels.size()), "",
                       std::to_string(shape.sections.size() - 1),
                       "There is one between any two consecutive sections.");
  for (std::size_t k = 0; k < levels.size(); ++k)
    require_at_least("levels[" + std::to_string(k) + "]", levels[k], 1);
  require_at_least("sum of levels", std::accumulate(levels.begin(), levels.end(), std::int64_t{0}), 2);
  require_lines(how.around);
  require_at_least("cover_rings", how.cover_rings, 1);
  require_at_least("ligament_rings", how.ligament_rings, 1);
  require_at_least("body_rings", how.body_rings, 1);
  double nodes = 1.0 + how.cover_rings + how.ligament_rings + how.body_rings;
  nodes *= how.around * (1 + std::accumulate(levels.begin(), levels.end(), 0.0));
  if (nodes > most_nodes)
    throw InvalidInput("Larynx", "nodes", nodes, "", "<= 5e7", "Fewer levels, lines or rings are needed.");
}

void validate(const Larynx::Shape& shape, const Larynx::Triangulated& how) {
  require_positive("size", how.size);
  require_not_negative("growth", how.growth);
  require_not_negative("tip_cut", how.tip_cut);
  require_lines(how.around);
  const double height = shape.sections[shape.layers_to_section].z - shape.sections[shape.layers_from_section].z;
  double area = 0;  // m^2, of the half section
  for (std::size_t k = 0; k + 1 < shape.sections.size(); ++k) {
    const auto &a = shape.sections[k], &b = shape.sections[k + 1];
    area += (b.z - a.z) * (shape.radius - 0.5 * (a.minor + b.minor));
  }
  const double far = std::hypot(shape.sections.back().z - shape.sections.front().z, shape.radius);
  // The triangulation is of order n^2 in the points of the section, of which these are lower bounds.
  const double points = std::max(height * shape.layer_thickness / (how.size * how.size),
                                 area / std::pow(how.size + how.growth * far, 2));
  if (points > most_section_points)
    throw InvalidInput("Larynx",
                       "points of the half section by size = " + number_text(how.size) +
                           " m and growth = " + number_text(how.growth),
                       points, "", "<= " + number_text(most_section_points), "Take a larger size or more growth.");
  if (how.around > most_lines)
    throw InvalidInput("Larynx", "around", how.around, "", "<= " + number_text(most_lines));
}

}  // namespace

void Larynx::validate() const {
  shape.validate();
  std::visit([&](const auto& how) { plica::validate(shape, how); }, meshed);
}

void name_larynx_parts(const LarynxMarks& marks, TetMesh& mesh) {
  std::vector<char> left = marks.airway, right = marks.airway;
  for (Eigen::Index node = 0; node < mesh.node_count(); ++node) {
    left[node] = left[node] && mesh.points(node, 0) <= 0;
    right[node] = right[node] && mesh.points(node, 0) >= 0;
  }
  const Boundary hull = boundary_of(mesh.cells);
  mesh.surfaces["airway"] = marked_faces(hull, marks.airway);
  mesh.surfaces["airway_left"] = marked_faces(hull, left);
  mesh.surfaces["airway_right"] = marked_faces(hull, right);
  const auto nodes = [](const std::vector<char>& marked) {
    std::vector<std::int32_t> found;
    for (std::size_t node = 0; node < marked.size(); ++node)
      if (marked[node]) found.push_back(static_cast<std::int32_t>(node));
    return Indices(Eigen::Map<const Indices>(found.data(), static_cast<Eigen::Index>(found.size())));
  };
  mesh.node_sets["wall"] = nodes(marks.wall);
  mesh.node_sets["ends"] = nodes(marks.end);
}

TetMesh larynx_mesh(const Larynx& larynx) {
  larynx.validate();
  if (const auto* how = std::get_if<Larynx::Levels>(&larynx.meshed)) return mesh_in_levels(larynx.shape, *how);
  return mesh_triangulated(larynx.shape, std::get<Larynx::Triangulated>(larynx.meshed));
}

TetMesh quadratic_larynx_mesh(const Larynx& larynx) {
  larynx.validate();
  if (const auto* how = std::get_if<Larynx::Levels>(&larynx.meshed))
    return to_quadratic(mesh_in_levels(larynx.shape, *how));
  return quadratic_mesh_triangulated(larynx.shape, std::get<Larynx::Triangulated>(larynx.meshed));
}

}  // namespace plica

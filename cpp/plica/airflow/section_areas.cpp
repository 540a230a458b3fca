#include "plica/airflow/section_areas.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "plica/airflow/facets.hpp"
#include "plica/core/constants.hpp"
#include "plica/core/error.hpp"
#include "plica/core/require.hpp"

namespace plica {
namespace {

constexpr int stations = 32;

/// Calls visit(face, facet, corner positions (c, 3)) for each facet of the surface.
template <class Visit>
void for_each_facet(const Points& x, const Faces& surface, const Facets& facets, const Visit& visit) {
  Points nodes(surface.cols(), 3);
  for (std::ptrdiff_t f = 0; f < surface.rows(); ++f) {
    for (std::ptrdiff_t c = 0; c < surface.cols(); ++c) nodes.row(c) = x.row(surface(f, c));
    const Points corners = facets.weights * nodes;
    for (const auto& facet : facets.triangles) visit(f, facet, corners);
  }
}

}  // namespace

void SectionAreas::add_row(const std::vector<Term>& terms, double spacing) {
  for (const Term& term : terms) nodes_ = std::max<std::ptrdiff_t>(nodes_, term.node + std::ptrdiff_t{1});
  terms_.insert(terms_.end(), terms.begin(), terms.end());
  row_start_.push_back(terms_.size());
  spacing_.push_back(spacing);
}

SectionAreas SectionAreas::elliptic(const Sections& sections) {
  for (const std::ptrdiff_t size : {sections.major.size(), static_cast<std::ptrdiff_t>(sections.right.size()),
                                    static_cast<std::ptrdiff_t>(sections.left.size())})
    require_size("SectionAreas", "the sections' parts", size, sections.count());
  SectionAreas found;
  found.sections_ = sections.count();
  for (std::ptrdiff_t i = 0; i < sections.count(); ++i) {
    std::vector<Term> terms;
    const auto s = static_cast<std::size_t>(i);
    for (const auto& [point, sign] : {std::pair(&sections.right[s], 1.0), std::pair(&sections.left[s], -1.0)})
      for (std::size_t k = 0; k < point->nodes.size(); ++k)
        terms.push_back({point->nodes[k], sign * sections.toward_right * point->weights[k]});
    found.add_row(terms, pi / 2 * sections.major[i]);
  }
  return found;
}

SectionAreas SectionAreas::cut(const TetMesh& mesh, const Faces& surface, Sections& sections) {
  require_size("SectionAreas", "a face of the surface", surface.cols(), 3, 6);
  require_indices("SectionAreas", "node of the surface", surface, mesh.node_count());
  require_at_least("SectionAreas", "heights", sections.height.size(), 1);
  const Facets facets(surface.cols());
  const Points& x = mesh.points;
  const Vector& height = sections.height;
  const std::ptrdiff_t count = sections.count();
  const double infinity = std::numeric_limits<double>::infinity();

  Vector front = Vector::Constant(count, infinity), back = -front;
  for_each_facet(x, surface, facets, [&](auto, const auto& facet, const Points& at) {
    for (int c = 0; c < 3; ++c) {
      const Vector3 a = at.row(facet[c]).transpose(), b = at.row(facet[(c + 1) % 3]).transpose();
      const auto [low, high] = std::minmax({a[2], b[2]});
      for (auto i = std::lower_bound(height.begin(), height.end(), low) - height.begin();
           i < count && height[i] <= high; ++i) {
        const double y = high > low ? a[1] + (height[i] - a[2]) / (b[2] - a[2]) * (b[1] - a[1]) : a[1];
        front[i] = std::min(front[i], y);
        back[i] = std::max(back[i], y);
      }
    }
  });
  sections.middle = (front + back) / 2;
  sections.major = (back - front) / 2;

  // Lines that pass through an edge of a facet would be counted twice or not at all: all are moved a little, and
  // further should one still meet an edge.
  struct Row {
    std::vector<Term> terms;
    int right = 0, left = 0;  // how often the line enters the tissue, and leaves it, toward larger x
  };
  std::vector<Row> rows;
  std::array<double, stations> along;  // of the lines, in half depths from the middle
  for (int j = 0; j < stations; ++j) along[static_cast<std::size_t>(j)] = std::cos(pi * (j + 0.5) / stations);
  const double range = height[count - 1] - height[0];
  for (int attempt = 1;; ++attempt) {
    rows.assign(static_cast<std::size_t>(count * stations), {});
    const double up = 1e-9 * attempt * range, ahead = 1.7e-9 * attempt;
    for_each_facet(x, surface, facets, [&](auto f, const auto& facet, const Points& at) {
      Eigen::Vector2d p[3];  // (y, z)
      for (int c = 0; c < 3; ++c) p[c] = at.row(facet[c]).template tail<2>().transpose();
      const auto cross = [](const Eigen::Vector2d& u, const Eigen::Vector2d& v) {
        return u[0] * v[1] - u[1] * v[0];
      };
      const double twice = cross(p[1] - p[0], p[2] - p[0]);  // x of the normal, into the air
      const auto [low, high] = std::minmax({p[0][1], p[1][1], p[2][1]});
      for (auto i = std::lower_bound(height.begin(), height.end(), low - up) - height.begin();
           i < count && height[i] + up <= high; ++i)
        for (int j = 0; j < stations; ++j) {
          const Eigen::Vector2d q(
              sections.middle[i] + sections.major[i] * (along[static_cast<std::size_t>(j)] + ahead),
              height[i] + up);
          double part[3];
          for (int c = 0; c < 3; ++c) part[c] = cross(p[(c + 1) % 3] - q, p[(c + 2) % 3] - q) / twice;
          if (!(part[0] > 0 && part[1] > 0 && part[2] > 0)) continue;
          Row& row = rows[static_cast<std::size_t>(i * stations + j)];
          ++(twice < 0 ? row.right : row.left);
          for (std::ptrdiff_t k = 0; k < surface.cols(); ++k) {
            double weight = 0;
            for (int c = 0; c < 3; ++c) weight += part[c] * facets.weights(facet[c], k);
            if (weight != 0) row.terms.push_back({surface(f, k), twice < 0 ? weight : -weight});
          }
        }
    });
    const auto open = std::find_if(rows.begin(), rows.end(),
                                   [](const Row& row) { return row.right == 0 || row.right != row.left; });
    if (open == rows.end()) break;
    if (attempt < 8) continue;
    const std::ptrdiff_t i = (open - rows.begin()) / stations, j = (open - rows.begin()) % stations;
    throw InvalidInput("Airflow: interface at (y, z) = (" +
                       number_text(sections.middle[i] + sections.major[i] * along[static_cast<std::size_t>(j)]) +
                       ", " + number_text(height[i]) + ") m is met " + std::to_string(open->left) +
                       " times on the side of smaller x, " + std::to_string(open->right) +
                       " times on that of larger x; must be met equally often, and at least once. "
                       "Is the whole airway in the surface?");
  }
  SectionAreas found;
  found.clipped_ = true;
  found.sections_ = count;
  for (std::ptrdiff_t i = 0; i < count; ++i)
    for (int j = 0; j < stations; ++j)
      found.add_row(rows[static_cast<std::size_t>(i * stations + j)].terms,
                    sections.major[i] * (std::cos(pi * j / stations) - std::cos(pi * (j + 1) / stations)));
  return found;
}

Vector SectionAreas::widths(const Points& x) const {
  require_at_least("SectionAreas", "x", x.rows(), nodes_);
  Vector widths(static_cast<std::ptrdiff_t>(spacing_.size()));
  for (std::size_t row = 0; row < spacing_.size(); ++row) {
    double sum = 0;
    for (std::size_t k = row_start_[row]; k < row_start_[row + 1]; ++k)
      sum += terms_[k].weight * x(terms_[k].node, 0);
    widths[static_cast<std::ptrdiff_t>(row)] = sum;
  }
  return widths;
}

Vector SectionAreas::areas(const Vector& widths) const {
  require_size("SectionAreas", "widths", widths.size(), width_count());
  Vector areas = Vector::Zero(sections_);
  const std::ptrdiff_t each = widths.size() / sections_;
  for (std::ptrdiff_t row = 0; row < widths.size(); ++row) {
    const double width = clipped_ && !(widths[row] > 0 || std::isnan(widths[row])) ? 0 : widths[row];
    areas[row / each] += spacing_[static_cast<std::size_t>(row)] * width;
  }
  return areas;
}

}  // namespace plica

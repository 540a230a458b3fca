#include <cmath>

#include "plica/tissue/element.hpp"

namespace plica {
namespace {

// All points with one coordinate 1 - 3 a and the others a.
void add_vertex_orbit(TetrahedronRule& rule, double a, double weight) {
  for (int i = 0; i < 4; ++i) {
    QuadraturePoint<4> point{{a, a, a, a}, weight};
    point.at[i] = 1 - 3 * a;
    rule.push_back(point);
  }
}

// All points with two coordinates a and the others 1/2 - a.
void add_edge_orbit(TetrahedronRule& rule, double a, double weight) {
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      QuadraturePoint<4> point{{0.5 - a, 0.5 - a, 0.5 - a, 0.5 - a}, weight};
      point.at[i] = point.at[j] = a;
      rule.push_back(point);
    }
  }
}

void add_vertex_orbit(TriangleRule& rule, double a, double weight) {
  for (int i = 0; i < 3; ++i) {
    QuadraturePoint<3> point{{a, a, a}, weight};
    point.at[i] = 1 - 2 * a;
    rule.push_back(point);
  }
}

}  // namespace

const TetrahedronRule& tetrahedron_rule_degree_2() {
  static const TetrahedronRule rule = [] {
    TetrahedronRule r;
    add_vertex_orbit(r, (5 - std::sqrt(5.0)) / 20, 0.25);
    return r;
  }();
  return rule;
}

const TetrahedronRule& tetrahedron_rule_degree_5() {
  static const TetrahedronRule rule = [] {
    const double root = std::sqrt(15.0);
    TetrahedronRule r{{{0.25, 0.25, 0.25, 0.25}, 16.0 / 135}};
    add_vertex_orbit(r, (7 - root) / 34, (2665 + 14 * root) / 37800);
    add_vertex_orbit(r, (7 + root) / 34, (2665 - 14 * root) / 37800);
    add_edge_orbit(r, (5 - root) / 20, 10.0 / 189);
    return r;
  }();
  return rule;
}

const TriangleRule& triangle_rule_degree_5() {
  static const TriangleRule rule = [] {
    const double root = std::sqrt(15.0);
    TriangleRule r{{{1.0 / 3, 1.0 / 3, 1.0 / 3}, 9.0 / 40}};
    add_vertex_orbit(r, (6 - root) / 21, (155 - root) / 1200);
    add_vertex_orbit(r, (6 + root) / 21, (155 + root) / 1200);
    return r;
  }();
  return rule;
}

}  // namespace plica

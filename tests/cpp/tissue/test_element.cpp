#include <doctest/doctest.h>

#include <cmath>

#include "../approx.hpp"
#include "plica/tissue/element.hpp"

using namespace plica;

namespace {

double factorial(int n) { return n < 2 ? 1 : n * factorial(n - 1); }

template <class Rule, std::size_t corners>
double mean_by_rule(const Rule& rule, const std::array<int, corners>& power) {
  double sum = 0;
  for (const auto& point : rule) {
    double term = point.weight;
    for (std::size_t i = 0; i < corners; ++i) term *= std::pow(point.at[i], power[i]);
    sum += term;
  }
  return sum;
}

// Largest error of a tetrahedron rule over all monomials in three barycentric coordinates of that degree;
// the mean of l1^a l2^b l3^c is 3! a! b! c! / (a + b + c + 3)!.
double tetrahedron_error(const TetrahedronRule& rule, int degree) {
  double worst = 0;
  for (int a = 0; a <= degree; ++a) {
    for (int b = 0; a + b <= degree; ++b) {
      const int c = degree - a - b;
      const double exact = 6 * factorial(a) * factorial(b) * factorial(c) / factorial(degree + 3);
      worst = std::max(worst, std::abs(mean_by_rule(rule, std::array<int, 4>{0, a, b, c}) / exact - 1));
    }
  }
  return worst;
}

double triangle_error(const TriangleRule& rule, int degree) {
  double worst = 0;
  for (int a = 0; a <= degree; ++a) {
    const int b = degree - a;
    const double exact = 2 * factorial(a) * factorial(b) / factorial(degree + 2);
    worst = std::max(worst, std::abs(mean_by_rule(rule, std::array<int, 3>{0, a, b}) / exact - 1));
  }
  return worst;
}

template <class Rule>
void check_inside_and_positive(const Rule& rule) {
  for (const auto& point : rule) {
    CHECK(point.weight > 0);
    double sum = 0;
    for (const double l : point.at) {
      CHECK(l > 0);
      sum += l;
    }
    CHECK(sum == approx(1).epsilon(1e-15));
  }
}

// Corners of a tetrahedron and the middles of its edges.
Points ten_nodes() {
  Points x(10, 3);
  x.topRows(4) << 0.1, 0.2, 0, 1.3, 0, 0.1, 0.2, 0.9, -0.1, 0.3, 0.2, 1.1;
  constexpr int edges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  for (int e = 0; e < 6; ++e) x.row(4 + e) = 0.5 * (x.row(edges[e][0]) + x.row(edges[e][1]));
  return x;
}

constexpr std::int32_t cell[10] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};

}  // namespace

TEST_CASE("each rule integrates every monomial up to its degree and fails one degree above") {
  const double round_off = 1e-13;  // of fifteen terms, relative to means down to 1e-3
  for (int degree = 0; degree <= 2; ++degree)
    CHECK(tetrahedron_error(tetrahedron_rule_degree_2(), degree) < round_off);
  CHECK(tetrahedron_error(tetrahedron_rule_degree_2(), 3) > 1e-3);
  for (int degree = 0; degree <= 5; ++degree) {
    CHECK(tetrahedron_error(tetrahedron_rule_degree_5(), degree) < round_off);
    CHECK(triangle_error(triangle_rule_degree_5(), degree) < round_off);
  }
  CHECK(tetrahedron_error(tetrahedron_rule_degree_5(), 6) > 1e-3);
  CHECK(triangle_error(triangle_rule_degree_5(), 6) > 1e-3);
}

TEST_CASE("the rules have positive weights and inner points") {
  CHECK(tetrahedron_rule_degree_2().size() == 4);
  CHECK(tetrahedron_rule_degree_5().size() == 15);
  CHECK(triangle_rule_degree_5().size() == 7);
  check_inside_and_positive(tetrahedron_rule_degree_2());
  check_inside_and_positive(tetrahedron_rule_degree_5());
  check_inside_and_positive(triangle_rule_degree_5());
}

TEST_CASE("quadratic shape functions are one at their node and zero at the others") {
  const std::array<std::array<double, 4>, 10> nodes = {{{1, 0, 0, 0},
                                                        {0, 1, 0, 0},
                                                        {0, 0, 1, 0},
                                                        {0, 0, 0, 1},
                                                        {.5, .5, 0, 0},
                                                        {0, .5, .5, 0},
                                                        {.5, 0, .5, 0},
                                                        {.5, 0, 0, .5},
                                                        {0, .5, 0, .5},
                                                        {0, 0, .5, .5}}};
  for (int i = 0; i < 10; ++i) {
    CHECK(quadratic_shapes(nodes[static_cast<std::size_t>(i)]) == ShapeValues::Unit(i));
  }
  const std::array<std::array<double, 3>, 6> face = {
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {.5, .5, 0}, {0, .5, .5}, {.5, 0, .5}}};
  for (int i = 0; i < 6; ++i) {
    CHECK(triangle_shapes(face[static_cast<std::size_t>(i)]) == Eigen::Matrix<double, 6, 1>::Unit(i));
  }
}

TEST_CASE("slopes of the shape functions are their finite differences") {
  const double h = 0.5;  // central differences of a quadratic are exact for any step
  const std::array<double, 4> at = {0.1, 0.2, 0.3, 0.4};
  const ShapeSlopes slopes = quadratic_slopes(at);
  CHECK(slopes.norm() > 1);
  for (std::size_t k = 0; k < 4; ++k) {
    auto up = at, down = at;
    up[k] += h;
    down[k] -= h;
    const ShapeValues difference = (quadratic_shapes(up) - quadratic_shapes(down)) / (2 * h);
    CHECK((difference - slopes.col(static_cast<int>(k))).norm() < 1e-14);
  }
  const std::array<double, 3> on_face = {0.2, 0.3, 0.5};
  for (std::size_t k = 0; k < 3; ++k) {
    auto up = on_face, down = on_face;
    up[k] += h;
    down[k] -= h;
    const Eigen::Matrix<double, 6, 1> difference = (triangle_shapes(up) - triangle_shapes(down)) / (2 * h);
    CHECK((difference - triangle_slopes(on_face).col(static_cast<int>(k))).norm() < 1e-14);
  }
}

TEST_CASE("the closed form of a straight element is the limit of the curved one") {
  Points x = ten_nodes();
  Element straight(2), curved(2);
  straight.place(x, cell);
  x(5, 0) += 1e-9;  // above the threshold of 1e-10, so that the 15-point integrals are taken
  curved.place(x, cell);
  CHECK(straight.volume() != curved.volume());
  CHECK(straight.volume() == approx(curved.volume()).epsilon(1e-8));
  Matrix6 D = Matrix6::Identity();
  D(0, 1) = D(1, 0) = 0.4;
  D(3, 5) = D(5, 3) = -0.2;
  double load[2][10], mass[2][100], blocks[2][900];
  straight.load(load[0]), curved.load(load[1]);
  straight.mass(mass[0]), curved.mass(mass[1]);
  straight.stiffness(D, blocks[0]), curved.stiffness(D, blocks[1]);
  // The move of 1e-9 changes every integral by some 1e-8 of its size (1).
  for (int i = 0; i < 10; ++i) CHECK(std::abs(load[0][i] - load[1][i]) < 1e-8);
  for (int i = 0; i < 100; ++i) CHECK(std::abs(mass[0][i] - mass[1][i]) < 1e-8);
  for (int i = 0; i < 900; ++i) CHECK(std::abs(blocks[0][i] - blocks[1][i]) < 3e-8);
  CHECK((straight.centroid_gradients() - curved.centroid_gradients()).norm() < 3e-8);
}

TEST_CASE("linear and straight quadratic tetrahedra carry the loads of the textbook") {
  const Points x = ten_nodes();
  Element linear(1), quadratic(2);
  linear.place(x, cell);
  quadratic.place(x, cell);
  double load[10];
  linear.load(load);
  for (int i = 0; i < 4; ++i) CHECK(load[i] == approx(linear.volume() / 4).epsilon(1e-14));
  quadratic.load(load);
  for (int i = 0; i < 10; ++i) {
    CHECK(load[i] == approx(quadratic.volume() * (i < 4 ? -0.05 : 0.2)).epsilon(1e-12));
  }
}

TEST_CASE("an element that is bent through itself has a negative least jacobian") {
  Points x = ten_nodes();
  Element element(2);
  element.place(x, cell);
  CHECK(element.least_jacobian() == approx(element.volume()).epsilon(1e-14));
  x.row(4) += 2 * (x.row(2) - x.row(4));  // the middle of an edge beyond the opposite corner
  element.place(x, cell);
  CHECK(element.least_jacobian() < 0);
}

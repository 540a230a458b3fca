#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "../approx.hpp"
#include "plica/contact/pairs.hpp"
#include "plica/mesh/block.hpp"

using namespace plica;

namespace {

constexpr double reach = 1.0;  // m; further than anything moves here

/// Two unit blocks of n^3 cells, the second to the right of the first with the gap between them.
struct Blocks {
  TetMesh mesh;
  Airway airway;
  std::ptrdiff_t first_nodes;
};
Blocks facing_blocks(int n, double gap = 0.1) {
  const TetMesh a = block_mesh({{-1, 0, 0}, {1, 1, 1}, {n, n, n}}),
                b = block_mesh({{gap, 0, 0}, {1, 1, 1}, {n, n, n}});
  Blocks blocks{combine_meshes(a, b, "a.", "b."), {}, a.node_count()};
  blocks.airway = matched_airway(blocks.mesh.points, flat_triangles(blocks.mesh.surface("a.x_max")),
                                 flat_triangles(blocks.mesh.surface("b.x_min")), Vector3::UnitX());
  return blocks;
}

Points shifted(const Blocks& blocks, const Vector3& by) {
  Points x = blocks.mesh.points;
  x.bottomRows(x.rows() - blocks.first_nodes).rowwise() += by.transpose();
  return x;
}

/// The node of `side` at (y, z), or -1.
std::int32_t node_at(const ContactSurface& side, const Points& x, double y, double z) {
  for (const auto node : side.nodes())
    if (std::abs(x(node, 1) - y) + std::abs(x(node, 2) - z) < 1e-9) return node;
  return -1;
}

}  // namespace

TEST_CASE("blocks apart have no candidates; overlapping ones have the gap of their distance") {
  const Blocks blocks = facing_blocks(3);
  Detector detector(blocks.airway, blocks.mesh.points);
  detector.update(blocks.mesh.points);
  CHECK(detector.inverted_tets().empty());
  CHECK(detector.candidates(detector.slave_side()).empty());

  const Points x = shifted(blocks, {-0.13, 0, 0});
  detector.update(x);
  for (const ContactSurface* side : {&detector.first(), &detector.second()}) {
    const auto nodes = detector.candidates(*side);
    CHECK(nodes == side->nodes());
    for (const auto node : nodes) {
      const Pair pair = detector.pair(node, x);
      CHECK(pair.gap(x) == approx(-0.03).epsilon(1e-12));
      CHECK(pair.penetrates(x, reach));
      CHECK(pair.weights.sum() == approx(1).epsilon(1e-14));
    }
  }
  CHECK(detector.overlap_volume(x, reach) == approx(2.0 / 3 * 0.03).epsilon(1e-12));  // two of three tetrahedra
}

TEST_CASE("blocks that slid past each other meet the plane and not their old partners") {
  const Blocks blocks = facing_blocks(4);
  const Points x = shifted(blocks, {-0.12, 0.09, -0.05});  // tangential offset far beyond the depth
  Detector detector(blocks.airway, blocks.mesh.points);
  detector.update(x);
  int inside = 0;
  for (const auto node : detector.candidates(detector.second())) {
    const Pair pair = detector.pair(node, x);
    const bool over = x(node, 1) < 1 && x(node, 2) > 0;
    CHECK(pair.penetrates(x, reach) == over);
    if (!over) continue;
    ++inside;
    CHECK(pair.gap(x) == approx(-0.02).epsilon(1e-12));
    CHECK((pair.normal - Vector3::UnitX()).norm() < 1e-14);  // from the master (first) towards the slave
    const Vector3 foot = x.row(node).transpose() - pair.offset(x);
    CHECK((foot - Vector3(0, x(node, 1), x(node, 2))).norm() < 1e-13);
  }
  CHECK(inside == 16);
}

TEST_CASE("blocks that tilt towards each other alike have not slid, one that is pushed along has") {
  const Blocks blocks = facing_blocks(2, 0.4);
  const double tilt = 0.3;
  Points x = blocks.mesh.points;
  for (std::int32_t i = 0; i < x.rows(); ++i) {  // mirror images, about axes that end on the plane between them
    const double side = i < blocks.first_nodes ? -1 : 1, depth = side * (x(i, 0) - 0.2) - 0.2, up = x(i, 2);
    x.row(i) << 0.2 + side * (std::cos(tilt) * depth + std::sin(tilt) * up), x(i, 1),
        std::cos(tilt) * up - std::sin(tilt) * depth;
  }
  Detector detector(blocks.airway, blocks.mesh.points);
  detector.update(x);
  const auto low = [&](const ContactSurface& side) {
    return *std::min_element(side.nodes().begin(), side.nodes().end(),
                             [&](auto a, auto b) { return x(a, 2) < x(b, 2); });
  };
  for (const ContactSurface* side : {&detector.first(), &detector.second()})
    CHECK(detector.slide(low(*side), x) == approx(0).epsilon(1e-12));
  const double along = 0.05;
  x.topRows(blocks.first_nodes).col(1).array() += along;
  detector.update(x);
  for (const ContactSurface* side : {&detector.first(), &detector.second()})
    CHECK(detector.slide(low(*side), x) == approx(along).epsilon(1e-12));
}

TEST_CASE("surfaces of other sizes take the nodes of the finer one as slaves") {
  // One square of the first against four of the second: the tetrahedra are given by hand and only name candidates.
  Points x(13, 3);
  Triangles first(2, 3), second(8, 3);
  for (int k = 0; k < 4; ++k) x.row(k) << 0, k % 2, k / 2;
  for (int k = 0; k < 9; ++k) x.row(4 + k) << 0.1, 0.5 * (k % 3), 0.5 * (k / 3);
  first << 0, 1, 3, 0, 3, 2;
  int f = 0;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const int a = 4 + i + 3 * j, b = a + 1, c = b + 3, d = a + 3;
      second.row(f++) << a, c, b;
      second.row(f++) << a, d, c;
    }
  Tets tets(9, 4);
  for (int k = 0; k < 9; ++k) tets.row(k) << 0, 1, 3, 4 + k;
  const Detector two(Airway{first, second, tets}, x);
  CHECK(&two.slave_side() == &two.second());
  CHECK(two.mean_edge() == approx(0.75 * (2 + std::sqrt(2.0)) / 3).epsilon(1e-13));

  Detector detector(Airway{first, second, tets}, x);
  x.bottomRows(9).col(0).array() = -0.01;
  detector.update(x);
  const auto nodes = detector.candidates(detector.slave_side());
  CHECK(nodes.size() == 9);
  for (const auto node : nodes) CHECK(detector.pair(node, x).gap(x) == approx(-0.01).epsilon(1e-12));
}

TEST_CASE("a matched pair seen from both sides is the same constraint") {
  const Blocks blocks = facing_blocks(2);
  Points x = shifted(blocks, {-0.13, 0, 0});
  for (std::ptrdiff_t i = 0; i < x.rows(); ++i) {  // bent alike, so that partners stay face to face
    const double bump = 0.05 * std::sin(2 * x(i, 1)) + 0.03 * x(i, 2);
    x(i, 0) += bump;
  }
  Detector detector(blocks.airway, blocks.mesh.points);
  detector.update(x);
  const auto middle = node_at(detector.first(), x, 0.5, 0.5), partner = node_at(detector.second(), x, 0.5, 0.5);
  REQUIRE(middle >= 0);
  REQUIRE(partner >= 0);
  const Pair from_first = detector.pair(middle, x), from_second = detector.pair(partner, x);
  // Feet are not the partners (the surface leans), but forces and directions agree to the depth times the slope.
  CHECK((from_first.normal + from_second.normal).norm() < 0.02);

  x = shifted(blocks, {-0.13, 0, 0});  // flat: exactly the same row
  detector.update(x);
  const Pair a = detector.pair(middle, x), b = detector.pair(partner, x);
  Vector of_a = Vector::Zero(x.size()), of_b = of_a;
  a.constraint().row(a.normal, 0.0).add_force(2.5, of_a);
  b.constraint().row(b.normal, 0.0).add_force(2.5, of_b);
  CHECK((of_a - of_b).norm() < 1e-14);
  CHECK(a.gap(x) == approx(b.gap(x)).epsilon(1e-14));
}

// A foot off a corner by so much of an edge has weights, and with them a normal, off by so much: nothing to snap.
TEST_CASE(
    "a foot 1e-11 off a corner tilts the normal by no more than that over the edge times the bend between nodes") {
  const double edge = 0.25, off = 1e-11;
  const Blocks blocks = facing_blocks(4);
  Points x = shifted(blocks, {-0.1, 0, 0});
  x.col(0).array() += 0.1 * (x.col(1).array() - 0.4).square() + 0.2 * (x.col(2).array() - 0.6).square();
  Detector detector(blocks.airway, x);
  detector.update(x);
  double bend = 0, largest = 0;
  const Triangles& triangles = detector.first().triangles();
  for (const auto& t : triangles.rowwise())
    for (int k = 0; k < 3; ++k)
      bend = std::max(bend, (detector.first().normal(t[k]) - detector.first().normal(t[(k + 1) % 3])).norm());
  for (const auto node : detector.first().nodes()) {
    const Vector3 shared = -detector.first().normal(node);
    CHECK((detector.pair(node, x).normal - shared).norm() < 1e-14);
    for (int direction = 0; direction < 8; ++direction) {
      const double angle = direction * std::acos(-1.0) / 4 + 0.1;
      Points moved = x;
      moved.row(node) += off * Eigen::RowVector3d(0, std::cos(angle), std::sin(angle));
      detector.update(x);  // a pair is found once an update
      const double tilt = (detector.pair(node, moved).normal - shared).norm();
      CHECK(tilt <= off / edge * bend + 1e-15);
      largest = std::max(largest, tilt);
    }
  }
  CHECK(largest > 0.05 * off / edge * bend);
}

TEST_CASE("the forces of a pair sum to zero without moment at the current positions") {
  const Blocks blocks = facing_blocks(2);
  Points x = shifted(blocks, {-0.13, 0.07, 0.02});
  Detector detector(blocks.airway, blocks.mesh.points);
  detector.update(x);
  int over = 0;
  for (const auto node : detector.candidates(detector.slave_side())) {
    const Pair pair = detector.pair(node, x);
    if ((pair.offset(x) - pair.gap(x) * pair.normal).norm() > 1e-12) continue;  // a foot on the rim
    ++over;
    Vector force = Vector::Zero(x.size());
    pair.constraint().row(pair.normal, 0.0).add_force(1.7, force);
    CHECK(force.norm() > 1);
    CHECK(as_points(force).colwise().sum().norm() < 1e-15);
    Vector3 moment = Vector3::Zero();
    for (std::ptrdiff_t i = 0; i < x.rows(); ++i)
      moment += Vector3(x.row(i)).cross(Vector3(as_points(force).row(i)));
    CHECK(moment.norm() < 1e-14);
  }
  CHECK(over >= 4);
}

TEST_CASE("each tetrahedron of the volume penalty pushes with kappa V / 4") {
  const Blocks blocks = facing_blocks(2);
  const Points x = shifted(blocks, {-0.13, 0.01, 0});
  Detector detector(blocks.airway, blocks.mesh.points);
  detector.update(x);
  const double kappa = 3e5;
  int pushing = 0;
  const Vector volumes = signed_volumes(x, blocks.airway.tets);
  for (const auto t : detector.inverted_tets()) {
    const Pair pair = detector.volume_pair(t, x, kappa);
    if (pair.key < 0) continue;
    ++pushing;
    CHECK(pair.key == t);
    const double force = -pair.stiffness * pair.gap(x);
    CHECK(force == approx(kappa * -volumes[t] / 4).epsilon(1e-12));
    const Constraint constraint = pair.constraint();  // a spring with this force, not an exact constraint
    CHECK(constraint.stiffness == pair.stiffness);
    CHECK(std::abs(constraint.residual(force, x)) < 1e-12 * -pair.gap(x));
  }
  CHECK(pushing == 16);  // two of the three tetrahedra of eight prisms
}

TEST_CASE("a node beside a bent surface is not contact though its airway is inverted") {
  const Blocks blocks = facing_blocks(2);
  // The corner node of the second block slides far out sideways and a little behind the first block's face.
  Points x = blocks.mesh.points;
  Detector detector(blocks.airway, blocks.mesh.points);
  const auto corner = node_at(detector.second(), x, 1, 1);
  REQUIRE(corner >= 0);
  x.row(corner) += Vector3(-0.3, 0.5, 0).transpose();
  detector.update(x);
  CHECK_FALSE(detector.inverted_tets().empty());
  const auto candidates = detector.candidates(detector.second());
  CHECK(std::find(candidates.begin(), candidates.end(), corner) != candidates.end());
  const Pair pair = detector.pair(corner, x);
  CHECK(pair.gap(x) < 0);
  CHECK_FALSE(pair.penetrates(x, reach));
  CHECK(detector.overlap_volume(x, reach) == 0);
}

TEST_CASE("no depth is confirmed beyond the reach of the motion") {
  const Blocks blocks = facing_blocks(2);
  const Points x = shifted(blocks, {-0.13, 0, 0});
  Detector detector(blocks.airway, blocks.mesh.points);
  detector.update(x);
  const Pair pair = detector.pair(detector.first().nodes()[4], x);
  CHECK(pair.penetrates(x, 0.031));
  CHECK_FALSE(pair.penetrates(x, 0.029));
  CHECK(detector.overlap_volume(x, 0.029) == 0);
  CHECK(detector.reach(blocks.mesh.points, x, 0.01) == approx(0.27).epsilon(1e-12));
}

namespace {

/// Two mirror-symmetric edges along y, of a face across x each and a face that rises away from the other body, its
/// normal `angle` (degrees) from x. Nodes 0, 1 (edge), 2, 3 of the first; 4 of the second, the end of its edge,
/// lies `depth` behind the first's face across x in the middle of its edge.
struct Edges {
  Points x = Points(8, 3);
  Airway airway{Triangles(2, 3), Triangles(2, 3), Tets(1, 4)};
  Vector3 upper_normal;

  Edges(double angle, double depth) {
    const double c = std::cos(angle * std::acos(-1.0) / 180), s = std::sqrt(1 - c * c);
    upper_normal = {c, 0, s};
    x << 0, 0, 0, 0, 1, 0, 0, 0.5, -1, -s, 0.5, c,  //
        -depth, 0.5, 0, -depth, 1.5, 0, -depth, 1, -1, s - depth, 1, c;
    airway.first << 1, 0, 2, 0, 1, 3;
    airway.second << 4, 5, 6, 5, 4, 7;
    airway.tets << 1, 0, 2, 4;
  }
};

}  // namespace

TEST_CASE(
    "a node behind a sharp edge is confirmed however its normals lean, and pushed within 60 degrees of its gap") {
  for (const double angle : {30.0, 55.0, 65.0, 70.0, 85.0}) {
    CAPTURE(angle);
    const double depth = 0.01;
    const Edges edges(angle, depth);
    const double off = depth * edges.upper_normal[0];  // the rising face is nearer than the one across x
    Detector detector(edges.airway, edges.x);
    detector.update(edges.x);
    REQUIRE(detector.candidates(detector.second()) == std::vector<std::int32_t>{4});
    const Pair pair = detector.pair(4, edges.x);
    CHECK(pair.weights.minCoeff() > 0);
    CHECK((pair.offset(edges.x) + off * edges.upper_normal).norm() < 1e-14);
    // The mean normal points along x; the force turns with it up to 60 degrees from the face's normal.
    const double cosine = std::max(edges.upper_normal[0], 0.5);
    CHECK(pair.normal.norm() == approx(1).epsilon(1e-12));
    CHECK(pair.normal.dot(edges.upper_normal) == approx(cosine).epsilon(0.05));
    CHECK(pair.gradient.dot(pair.normal) == approx(1).epsilon(1e-12));
    CHECK(pair.gradient.cross(edges.upper_normal).norm() < 1e-12 * pair.gradient.norm());
    CHECK(pair.penetrates(edges.x, reach));
    // The reach bounds the way to the surface; the gap is that way along the normal and longer.
    CHECK(-pair.gap(edges.x) == approx(off / cosine).epsilon(0.05));
    CHECK(pair.penetrates(edges.x, 1.01 * off));
    CHECK_FALSE(pair.penetrates(edges.x, 0.99 * off));

    const Edges apart(angle, -depth);
    detector.update(apart.x);
    CHECK(detector.candidates(detector.second()).empty());
    CHECK_FALSE(detector.pair(4, apart.x).penetrates(apart.x, reach));
  }
}

TEST_CASE("edges that cross are found where no node has") {
  // Two roofs whose ridges cross at right angles: the first points along y, the second along z.
  Points x(8, 3);
  x << 0, -1, 0, 0, 1, 0, -1, 0, -1, -1, 0, 1,  // ridge 0-1, eaves 2, 3
      0.1, 0, -1, 0.1, 0, 1, 1.1, -1, 0, 1.1, 1, 0;
  Triangles first(2, 3), second(2, 3);
  first << 0, 1, 3, 1, 0, 2;
  second << 4, 5, 7, 5, 4, 6;
  Tets tets(1, 4);
  tets << 0, 1, 4, 5;
  if (signed_volumes(x, tets)[0] < 0) tets.col(2).swap(tets.col(3));
  Detector detector(Airway{first, second, tets}, x);
  detector.update(x);
  REQUIRE(detector.first().normal(0)[0] > 0);
  REQUIRE(detector.second().normal(4)[0] < 0);
  CHECK(detector.edge_crossings(x, reach).empty());

  x.bottomRows(4).col(0).array() -= 0.12;
  detector.update(x);
  const auto crossings = detector.edge_crossings(x, reach);
  REQUIRE(crossings.size() == 1);
  CHECK((crossings[0].place - Vector3(-0.01, 0, 0)).norm() < 1e-14);
  CHECK(crossings[0].volume == approx(2 * 2 * 0.02 / 6).epsilon(1e-12));
  CHECK(detector.volume_pair(0, x, 1.0).key == -1);
  for (const auto node : detector.candidates(detector.second()))
    CHECK_FALSE(detector.pair(node, x).penetrates(x, reach));

  for (const int axis : {1, 2})
    for (const double way : {-1.5, 1.5}) {  // past the ends of either
      Points past = x;
      past.bottomRows(4).col(axis).array() += way;
      detector.update(past);
      CHECK(detector.edge_crossings(past, reach).empty());
    }
  x.bottomRows(4).col(1).array() += 5;  // beside each other: inverted or not, nothing crosses
  detector.update(x);
  CHECK(detector.edge_crossings(x, reach).empty());
}

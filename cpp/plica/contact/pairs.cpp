#include "plica/contact/pairs.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "plica/core/error.hpp"

namespace plica {

namespace {

double volume(const Points& x, const Eigen::Matrix<std::int32_t, 1, 4>& tet) {
  const Vector3 o = x.row(tet[0]);
  return (x.row(tet[1]).transpose() - o).cross(x.row(tet[2]).transpose() - o).dot(x.row(tet[3]).transpose() - o) /
         6.0;
}

/// Signed: the volume over a third of the largest face; negative where inverted.
double least_height(const Points& x, const Eigen::Matrix<std::int32_t, 1, 4>& tet) {
  double largest = 0;
  for (int k = 0; k < 4; ++k) {
    const Vector3 a = x.row(tet[(k + 1) % 4]), b = x.row(tet[(k + 2) % 4]), c = x.row(tet[(k + 3) % 4]);
    largest = std::max(largest, 0.5 * (b - a).cross(c - a).norm());
  }
  return largest > 0 ? 3 * volume(x, tet) / largest : 0.0;
}

/// v without the directions in which the foot follows the slave: the triangle's plane, an edge, or none.
Vector3 across_foot(const Vector3& v, const Foot& foot, const std::array<Vector3, 3>& corners) {
  std::array<int, 3> loaded{};
  int count = 0;
  for (int k = 0; k < 3; ++k)
    if (foot.weights[k] > 0) loaded[count++] = k;
  if (count == 3) {
    const Vector3 m = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    return v.dot(m) * m;
  }
  if (count == 2) {
    const Vector3 e = (corners[loaded[1]] - corners[loaded[0]]).normalized();
    return v - v.dot(e) * e;
  }
  return v;
}

/// Sets the pair's normal and gradient from the mean normal n and the master's own, m (docs/theory/contact.md,
/// "Pair").
void set_directions(Pair& pair, const Vector3& n, const Vector3& m, const Foot& foot,
                    const std::array<Vector3, 3>& corners) {
  constexpr double least = 0.5;  // cosine between force and gap
  Vector3 across = across_foot(n, foot, corners);
  // Over a sharp edge n may lie nearly along the surface; the less it says, the more the master's own counts.
  if (const double length = across.norm(); length < least)
    across += (1 - length / least) * across_foot(m, foot, corners);
  const double length = across.norm();
  pair.normal = pair.gradient = n;
  if (!(length > 0)) return;  // a triangle without area says nothing of the distance
  across /= length;
  if (across.dot(n) < least) {  // turned to 60 degrees from the gap, within the plane of both
    const Vector3 along = (n - n.dot(across) * across).normalized();
    pair.normal = least * across + std::sqrt(1 - least * least) * along;
  }
  pair.gradient = across / across.dot(pair.normal);
}

Airway checked(Airway airway, std::ptrdiff_t node_count) {
  const auto check = [&](const auto& cells, const char* name) {
    for (std::ptrdiff_t i = 0; i < cells.size(); ++i)
      if (const std::int32_t node = cells.data()[i]; node < 0 || node >= node_count)
        throw InvalidInput("Airway", std::string("node of ") + name, node, "",
                           "in [0, " + std::to_string(node_count) + ")", "The airway belongs to another mesh.");
  };
  check(airway.first, "first");
  check(airway.second, "second");
  check(airway.tets, "tets");
  return airway;
}

}  // namespace

Constraint Pair::constraint() const {
  Constraint constraint;
  constraint.key = key;
  constraint.slave = slave;
  constraint.normal = normal;
  constraint.gradient = gradient;
  constraint.stiffness = stiffness;
  constraint.weights.push_back({slave, 1.0});
  for (int k = 0; k < 3; ++k)
    if (weights[k] != 0.0) constraint.weights.push_back({master[k], -weights[k]});
  return constraint;
}

Detector::Detector(Airway airway, const Points& reference)
    : airway_(checked(std::move(airway), reference.rows())),
      reference_(reference),
      first_(airway_.first, reference.rows()),
      second_(airway_.second, reference.rows()),
      pairs_(static_cast<std::size_t>(reference.rows())),
      last_foot_(static_cast<std::size_t>(reference.rows()), -1),
      partner_(static_cast<std::size_t>(reference.rows()), -1) {
  std::vector<std::int32_t> all = surface_nodes(airway_);
  nodes_ = Eigen::Map<Indices>(all.data(), static_cast<std::ptrdiff_t>(all.size()));
  const double first_edge = first_.mean_edge(reference), second_edge = second_.mean_edge(reference);
  mean_edge_ = 0.5 * (first_edge + second_edge);
  slave_is_first_ = first_edge <= second_edge * (1 + 1e-6);  // alike to round-off counts as alike
  join();
  look_everywhere();
}

void Detector::look_everywhere() {
  shown_.resize(static_cast<std::size_t>(airway_.tets.rows()));
  std::iota(shown_.begin(), shown_.end(), 0);
  first_.look_everywhere();
  second_.look_everywhere();
}

void Detector::look_at(const Neighbourhood& part) {
  if (airway_.renewed)
    throw InvalidInput("Detector: a part to look at; must be of an airway that does not change.");
  require_indices("Detector", "tetrahedron",
                  Eigen::Map<const Indices>(part.tets.data(), static_cast<std::ptrdiff_t>(part.tets.size())),
                  airway_.tets.rows());
  shown_ = part.tets;
  first_.look_at(part.first);
  second_.look_at(part.second);
}

void Detector::join() {
  const Vector3& facing = airway_.facing;
  const auto beside = [&](std::int32_t a,
                          std::int32_t b) {  // m, across the direction in which nodes face each other
    const Vector3 apart = reference_.row(b) - reference_.row(a);
    return (apart - facing.dot(apart) * facing).norm();
  };
  for (std::ptrdiff_t t = 0; t < airway_.tets.rows(); ++t)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const std::int32_t a = airway_.tets(t, i), b = airway_.tets(t, j);
        if (first_.contains(a) == first_.contains(b) && second_.contains(a) == second_.contains(b)) continue;
        if (partner_[a] < 0 || beside(a, b) < beside(a, partner_[a])) partner_[a] = b;
      }
}

void Detector::renew(const Points& x, double depth) {
  if (!airway_.renewed) return;
  forget_pairs();
  first_.update(x);
  second_.update(x);
  airway_.tets = airway_.renewed(x, first_, second_, depth);
  shown_.resize(static_cast<std::size_t>(airway_.tets.rows()));
  std::iota(shown_.begin(), shown_.end(), 0);
  std::fill(partner_.begin(), partner_.end(), -1);
  join();
}

void Detector::update(const Points& x) {
  forget_pairs();
  first_.update(x);
  second_.update(x);
  inverted_ = find_inverted(x, airway_.tets, shown_);
  if (airway_.renewed) find_thin(x);
}

void Detector::find_thin(const Points& x) {
  std::vector<double> bulge(partner_.size(), 0.0);
  for (const ContactSurface* side : {&first_, &second_})
    for (const std::int32_t node : side->nodes()) bulge[node] = std::max(bulge[node], side->bulge(node, x));
  thin_.clear();
  for (std::int32_t t = 0; t < airway_.tets.rows(); ++t) {
    double slack = 0;
    for (const std::int32_t node : airway_.tets.row(t)) slack = std::max(slack, bulge[node]);
    if (least_height(x, airway_.tets.row(t)) <= slack) thin_.push_back(t);
  }
}

std::vector<std::int32_t> Detector::candidates(const ContactSurface& side) const {
  const ContactSurface& other = &side == &first_ ? second_ : first_;
  std::vector<std::int32_t> found;
  for (const auto* tets : {&inverted_, &thin_})
    for (const std::int32_t t : *tets)
      for (const std::int32_t node : airway_.tets.row(t))
        if (side.contains(node) && !other.contains(node)) found.push_back(node);
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

std::vector<Pair> Detector::inside(const ContactSurface& side, const Points& x, double reach) {
  const ContactSurface& other = &side == &first_ ? second_ : first_;
  std::vector<Pair> found;
  const auto look_at = [&](std::int32_t node) {
    if (const Pair& by_node = pair(node, x); by_node.penetrates(x, reach)) found.push_back(by_node);
  };
  if (!airway_.renewed) {
    for (const std::int32_t node : candidates(side)) look_at(node);
    return found;
  }
  for (const std::int32_t node : side.nodes())
    if (!other.contains(node) && other.within(x, x.row(node), reach)) look_at(node);
  return found;
}

const Pair& Detector::pair(std::int32_t slave, const Points& x) {
  Pair& pair = pairs_[static_cast<std::size_t>(slave)];
  if (pair.slave >= 0) return pair;
  paired_.push_back(slave);
  return pair = found_pair(slave, x);
}

void Detector::forget_pairs() {
  for (const std::int32_t node : paired_) pairs_[static_cast<std::size_t>(node)].slave = -1;
  paired_.clear();
}

Pair Detector::found_pair(std::int32_t slave, const Points& x) {
  const bool on_first = first_.contains(slave);
  const ContactSurface& own = on_first ? first_ : second_;
  const ContactSurface& other = on_first ? second_ : first_;
  std::int32_t& last = last_foot_[static_cast<std::size_t>(slave)];
  const Foot foot = other.closest(x, x.row(slave), last);
  last = foot.triangle;
  foot_on_rim_ = foot_on_rim_ || other.on_rim(foot.triangle);

  Pair pair;
  pair.key = pair.slave = slave;
  for (int k = 0; k < 3; ++k) pair.master[k] = other.triangles()(foot.triangle, k);
  pair.weights = foot.weights;
  const Vector3 of_master = other.normal(foot), mean = of_master - own.normal(slave);
  // Surfaces that do not face each other (a node behind the master's rim) keep the master's own normal.
  set_directions(pair, mean.squaredNorm() > 1.0 ? Vector3(mean.normalized()) : of_master, of_master, foot,
                 {x.row(pair.master[0]), x.row(pair.master[1]), x.row(pair.master[2])});
  return pair;
}

Pair Detector::volume_pair(std::int32_t tet, const Points& x, double kappa) const {
  std::array<std::int32_t, 4> of_first{}, of_second{};
  int n_first = 0, n_second = 0;
  for (int k = 0; k < 4; ++k) {
    const std::int32_t node = airway_.tets(tet, k);
    // A node common to both surfaces counts for the side that completes a face.
    if (first_.contains(node)) of_first[n_first++] = node;
    if (second_.contains(node)) of_second[n_second++] = node;
  }
  Pair pair;
  if (!(n_first == 3 && n_second == 1) && !(n_first == 1 && n_second == 3)) return pair;
  const bool slave_first = n_first == 1;
  if (slave_first ? second_.contains(of_first[0]) : first_.contains(of_second[0])) return pair;
  pair.slave = slave_first ? of_first[0] : of_second[0];
  for (int k = 0; k < 3; ++k) pair.master[k] = slave_first ? of_second[k] : of_first[k];
  pair.weights.setConstant(1.0 / 3.0);
  const Vector3 a = x.row(pair.master[0]), b = x.row(pair.master[1]), c = x.row(pair.master[2]);
  Vector3 twice_area = (b - a).cross(c - a);
  const ContactSurface& own = slave_first ? first_ : second_;
  const ContactSurface& other = slave_first ? second_ : first_;
  const Vector3 facing = other.normal(pair.master[0]) - own.normal(pair.slave);
  if (twice_area.dot(facing) < 0) twice_area = -twice_area;
  const double area = 0.5 * twice_area.norm();
  if (!(area > 0)) return pair;  // a face without area pushes nothing
  pair.key = tet;
  pair.normal = pair.gradient = twice_area / (2.0 * area);
  pair.stiffness = kappa * area / 12.0;
  return pair;
}

std::vector<EdgeCrossing> Detector::edge_crossings(const Points& x, double reach) const {
  std::vector<EdgeCrossing> found;
  for (const std::int32_t t : inverted_) {
    std::array<std::int32_t, 2> e1{}, e2{};
    int n1 = 0, n2 = 0;
    bool common = false;
    for (int k = 0; k < 4; ++k) {
      const std::int32_t node = airway_.tets(t, k);
      const bool f = first_.contains(node), s = second_.contains(node);
      common = common || (f && s);
      if (f && !s && n1 < 2) e1[n1] = node;
      if (s && !f && n2 < 2) e2[n2] = node;
      n1 += f && !s;
      n2 += s && !f;
    }
    if (common || n1 != 2 || n2 != 2) continue;
    const Vector3 a = x.row(e1[0]), d1 = x.row(e1[1]).transpose() - a, b = x.row(e2[0]),
                  d2 = x.row(e2[1]).transpose() - b;
    const double d11 = d1.squaredNorm(), d12 = d1.dot(d2), d22 = d2.squaredNorm();
    const double det = d11 * d22 - d12 * d12;
    if (det <= 1e-12 * d11 * d22) continue;  // parallel edges share no single closest point
    const Vector3 r = b - a;
    const double s = (r.dot(d1) * d22 - r.dot(d2) * d12) / det, u = (r.dot(d1) * d12 - r.dot(d2) * d11) / det;
    if (s <= 0 || s >= 1 || u <= 0 || u >= 1) continue;
    const Vector3 p1 = a + s * d1, p2 = b + u * d2;
    const Vector3 across = p2 - p1;
    const Vector3 facing = (1 - s) * first_.normal(e1[0]) + s * first_.normal(e1[1]) -
                           (1 - u) * second_.normal(e2[0]) - u * second_.normal(e2[1]);
    const double wrong_way = -across.dot(facing.normalized());
    if (wrong_way > 0 && wrong_way <= reach && 4 * wrong_way * wrong_way >= across.squaredNorm())
      found.push_back({0.5 * (p1 + p2), std::abs(volume(x, airway_.tets.row(t)))});
  }
  return found;
}

double Detector::slide(std::int32_t node, const Points& x) const {
  const std::int32_t partner = partner_[node];
  if (airway_.renewed || partner < 0) return 0.0;
  const Vector3 n = (first_.contains(node) ? first_ : second_).normal(node);
  const Vector3 apart = x.row(node) - x.row(partner), &facing = airway_.facing;
  const Vector3 at_rest = reference_.row(node) - reference_.row(partner);
  const Vector3 moved = apart - (at_rest - facing.dot(at_rest) * facing);  // they may close along `facing`
  return (moved - n.dot(moved) * n).norm();
}

double Detector::reach(const Points& before, const Points& x, double depth) const {
  double largest = 0;
  for (const std::int32_t node : nodes_)
    largest = std::max(largest, (x.row(node) - before.row(node)).squaredNorm());
  return 2 * std::sqrt(largest) + depth;
}

Detector::Deepest Detector::deepest(const Points& x, double reach) {
  Deepest found;
  for (const ContactSurface* side : {&first_, &second_})
    for (const Pair& by_node : inside(*side, x, reach))
      if (by_node.gap(x) < found.gap) found = {by_node.slave, by_node.gap(x)};
  return found;
}

double Detector::overlap_volume(const Points& x, double reach) {
  double sum = 0;
  for (const std::int32_t t : inverted_) {
    const Pair by_volume = volume_pair(t, x, 1.0);
    if (by_volume.key >= 0 && pair(by_volume.slave, x).penetrates(x, reach))
      sum += std::abs(volume(x, airway_.tets.row(t)));
  }
  return sum;
}

}  // namespace plica

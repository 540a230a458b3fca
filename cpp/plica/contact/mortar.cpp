#include "plica/contact/mortar.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "plica/contact/facing.hpp"
#include "plica/core/error.hpp"

namespace plica {

namespace {

void check(const Faces& faces, const ContactSurface& surface, const char* name) {
  const Triangles flat = flat_triangles(faces);
  if (flat.rows() != surface.triangles().rows() || flat != surface.triangles())
    throw InvalidInput(std::string("Mortar: ") + name +
                       "; must have the flat triangles of the airway's surface of that name, in their order.");
}

class MortarAverages final : public ConstraintKind {
 public:
  MortarAverages(Detector& detector, Faces first, Faces second)
      : detector_(detector),
        slave_{detector.slave_side(), detector.slave_is_first() ? first : second},
        master_{detector.master_side(), detector.slave_is_first() ? second : first},
        facing_(slave_, master_),
        corners_(static_cast<std::size_t>(detector.node_count()), 0) {
    for (std::ptrdiff_t face = 0; face < slave_.faces.rows(); ++face)
      for (int k = 0; k < 3; ++k) corners_[static_cast<std::size_t>(slave_.faces(face, k))] = 1;
  }

  void update(const Points&) override { facing_.update(); }

  std::vector<std::int32_t> violated(const Points& x, double reach, const ContactSurface& side,
                                     double least) override {
    return &side == &slave_.flat ? violated_averages(x, reach, least) : hidden_nodes(x, reach, least);
  }

  bool knows(std::int32_t key) const override {
    const std::int32_t nodes = detector_.node_count();
    return key < nodes ? is_corner(key) : detector_.contains(key - nodes);
  }

  Constraint at(std::int32_t key, const Points& x, double reach) override {
    if (key < x.rows()) return average_at(key, x, reach);
    Constraint of_node = detector_.pair(key - static_cast<std::int32_t>(x.rows()), x).constraint();
    of_node.key = key;
    of_node.depth = left_to_averages(of_node.slave);
    return of_node;
  }

  std::vector<PressedNode> pressed(const ContactSurface& side, const Contact& contact, const Points& x) override {
    std::vector<PressedNode> found = pressed_averages(contact, x);
    for (std::size_t i = 0; i < contact.closed.size(); ++i)
      if (const auto node = contact.closed[i] - static_cast<std::int32_t>(x.rows());
          node >= 0 && side.contains(node)) {
        const double area = side.tributary_area(node);
        found.push_back(
            {node, area, contact.force[static_cast<std::ptrdiff_t>(i)] / area, side.tributary_stretch(node, x)});
      }
    return found;
  }

  Vector pressure(const Contact& contact, const Points& x) override {
    Vector pressure = Vector::Zero(x.rows());
    const std::vector<PressedNode> corners = pressed_averages(contact, x);
    for (const PressedNode& corner : corners) pressure[corner.node] = corner.pressure;
    if (slave_.split() > 1)  // linear along the sides
      for (const PressedNode& corner : corners)
        for (const std::int32_t triangle : slave_.flat.fan(corner.node)) {
          const auto face = slave_.faces.row(slave_.face_of(triangle));
          for (int k = 0; k < 3; ++k)
            pressure[face[3 + k]] = 0.5 * (pressure[face[k]] + pressure[face[(k + 1) % 3]]);
        }
    for (const std::int32_t node : master_.flat.nodes()) {
      if (slave_.flat.contains(node) || contact.nodal_force.segment<3>(3 * node).isZero(0)) continue;
      const Pair on_slave = detector_.pair(node, x);
      for (int k = 0; k < 3; ++k) pressure[node] += on_slave.weights[k] * pressure[on_slave.master[k]];
    }
    for (std::size_t i = 0; i < contact.closed.size(); ++i)
      if (const auto node = contact.closed[i] - static_cast<std::int32_t>(x.rows()); node >= 0) {
        const ContactSurface& side = slave_.flat.contains(node) ? slave_.flat : master_.flat;
        pressure[node] += contact.force[static_cast<std::ptrdiff_t>(i)] / side.tributary_area(node);
      }
    return pressure;
  }

 private:
  /// Of a slave face, and not common to both surfaces; any number may be asked for.
  bool is_corner(std::int32_t node) const {
    return detector_.contains(node) && slave_.flat.contains(node) && !master_.flat.contains(node) &&
           corners_[static_cast<std::size_t>(node)];
  }

  /// m^2, the integral of a corner's hat over the flat triangles around it.
  double hat(std::int32_t corner) const { return slave_.split() * slave_.flat.tributary_area(corner); }

  std::vector<PressedNode> pressed_averages(const Contact& contact, const Points& x) {
    constexpr double least = 0.05;  // -, of a hat
    std::vector<PressedNode> found;
    for (std::size_t i = 0; i < contact.closed.size(); ++i) {
      const std::int32_t corner = contact.closed[i];
      if (corner >= x.rows()) continue;
      // A sliver that faces the other side may carry a force, but says nothing of pressure.
      const double area =
          std::max(least * hat(corner), average_at(corner, x, std::numeric_limits<double>::infinity()).area);
      auto [low, high] = slave_.flat.tributary_stretch(corner, x);
      if (slave_.split() > 1) low = 2 * low - x(corner, 1), high = 2 * high - x(corner, 1);  // to the mid-sides
      found.push_back({corner, area, contact.force[static_cast<std::ptrdiff_t>(i)] / area, {low, high}});
    }
    return found;
  }

  std::vector<std::int32_t> violated_averages(const Points& x, double reach, double least) {
    std::vector<std::int32_t> found;
    std::vector<std::int32_t> named = detector_.candidates(slave_.flat);
    for (const Pair& pair : detector_.inside(slave_.flat, x, reach)) named.push_back(pair.slave);
    for (const std::int32_t node : named)
      for (const std::int32_t triangle : slave_.flat.fan(node))
        for (int k = 0; k < 3; ++k) found.push_back(slave_.faces(slave_.face_of(triangle), k));
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    const auto kept = std::remove_if(found.begin(), found.end(), [&](std::int32_t corner) {
      if (master_.flat.contains(corner)) return true;
      const Constraint average = average_at(corner, x, reach);
      return average.key < 0 || !(average.gap(x) < -least);
    });
    found.erase(kept, found.end());
    return found;
  }

  /// How deep the averages may leave a node inside, m.
  double left_to_averages(std::int32_t node) const {
    constexpr double share = 0.04;  // of an edge between nodes
    const ContactSurface& side = slave_.flat.contains(node) ? slave_.flat : master_.flat;
    return share * std::sqrt(side.tributary_area(node));
  }

  /// Keys of single nodes of either side that the averages leave well inside, as where what touches is narrower
  /// than a face, most of which is open.
  std::vector<std::int32_t> hidden_nodes(const Points& x, double reach, double least) {
    std::vector<std::int32_t> found;
    for (const ContactSurface* side : {&slave_.flat, &master_.flat})
      for (const Pair& pair : detector_.inside(*side, x, reach))
        if (pair.gap(x) < -(least + left_to_averages(pair.slave)))
          found.push_back(static_cast<std::int32_t>(x.rows()) + pair.slave);
    return found;
  }

  Constraint average_at(std::int32_t corner, const Points& x, double reach) {
    Constraint average;
    std::map<std::int32_t, double> shares;                         // by node, ascending
    for (const std::int32_t triangle : slave_.flat.fan(corner)) {  // of a face the one at this corner
      const std::int32_t face = slave_.face_of(triangle);
      const int k = slave_.corner(face, corner);
      for (const FacingPoint& point : facing_.of(face, x)) {
        if (point.behind > reach) continue;  // another part of the master lies there
        const double amount = point.hats[k] * point.area;
        average.area += amount;
        average.normal += amount * point.normal;
        for (Eigen::Index i = 0; i < point.slave.size(); ++i)
          shares[slave_.faces(face, i)] += amount * point.slave[i];
        for (Eigen::Index i = 0; i < point.master.size(); ++i)
          shares[master_.faces(point.master_face, i)] -= amount * point.master[i];
      }
    }
    if (!(average.area > 0) || !(average.normal.norm() > 0)) return {};
    for (const auto& [node, share] : shares) average.weights.push_back({node, share / average.area});
    average.key = average.slave = corner;
    average.normal.normalize();
    average.gradient = average.normal;
    average.support = average.area / hat(corner);
    return average;
  }

  Detector& detector_;
  FacedSide slave_, master_;
  FacingPoints facing_;
  std::vector<char> corners_;  // (n) of the slave's faces
};

}  // namespace

std::unique_ptr<ConstraintKind> mortar_averages(Detector& detector, Faces first, Faces second) {
  check(first, detector.first(), "first");
  check(second, detector.second(), "second");
  return std::make_unique<MortarAverages>(detector, std::move(first), std::move(second));
}

}  // namespace plica

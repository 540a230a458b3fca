#include "plica/dynamics/contact_record.hpp"

#include <algorithm>
#include <limits>

namespace plica {

namespace {

using Interval = std::pair<double, double>;

/// Loaded area, the stretches of y that the loaded nodes stand for, and peak pressure of one side.
struct SideMeasure {
  double area = 0.0, peak = 0.0;
  std::vector<Interval> stretches;
};

/// Nodes that carry less than a thousandth of the largest force are not loaded: those of round-off, as a corner of
/// a triangle on whose opposite side a slave lies, and the faint rim of the contact. The peak pressure is of all:
/// on so little force there is next to none.
SideMeasure measure_side(const std::vector<PressedNode>& nodes) {
  constexpr double least = 1e-3;  // of the largest force
  double largest = 0.0;
  for (const PressedNode& node : nodes) largest = std::max(largest, node.pressure * node.area);
  SideMeasure side;
  for (const PressedNode& node : nodes) {
    side.peak = std::max(side.peak, node.pressure);
    if (!(node.pressure * node.area > least * largest)) continue;
    side.area += node.area;
    side.stretches.push_back(node.stretch);
  }
  return side;
}

/// Length of the union, m.
double covered(std::vector<Interval> stretches) {
  std::sort(stretches.begin(), stretches.end());
  double sum = 0.0, end = -std::numeric_limits<double>::infinity();
  for (const auto& [from, to] : stretches) {
    sum += std::max(0.0, to - std::max(from, end));
    end = std::max(end, to);
  }
  return sum;
}

/// Sum over the nodes of one side, half of the force on a node common to both.
Vector3 sum_of_forces(const ContactSurface& side, const ContactSurface& other, const Vector& force) {
  Vector3 sum = Vector3::Zero();
  for (const std::int32_t node : side.nodes())
    sum += (other.contains(node) ? 0.5 : 1.0) * force.segment<3>(3 * node);
  return sum;
}

}  // namespace

Pressed measure(const std::vector<PressedNode>& first, const std::vector<PressedNode>& second) {
  const SideMeasure one = measure_side(first), other = measure_side(second);
  std::vector<Interval> both = one.stretches;
  both.insert(both.end(), other.stretches.begin(), other.stretches.end());
  return {0.5 * (one.area + other.area), covered(std::move(both)), std::max(one.peak, other.peak)};
}

ContactRecord contact_record(Collision& collision, const Contacts& contacts, const Points& x_before, double reach,
                             const Contact& now, const Points& x) {
  ContactRecord record;
  Detector& detector = collision.detector();
  record.passes = contacts.passes;
  record.pivots = contacts.pivots;
  record.augmentations = contacts.augmentations;
  record.gap_error = contacts.gap_error;
  record.converged = contacts.converged;
  record.facing = contacts.facing;
  for (std::size_t i = contacts.constraints.size(); i < contacts.rows.size(); ++i)
    record.friction_loss -= contacts.force[static_cast<std::ptrdiff_t>(i)] *
                            (contacts.rows[i].moving(x) - contacts.rows[i].moving(x_before));
  const Vector& nodal = now.nodal_force;
  for (std::size_t i = 0; i < contacts.constraints.size(); ++i) {
    const double force = contacts.force[static_cast<std::ptrdiff_t>(i)];
    if (force == 0.0) continue;
    ++record.rows;
    const std::int32_t slave = contacts.constraints[i].slave;
    record.slide = std::max(record.slide, detector.slide(slave, x) / detector.mean_edge());
    // Along the direction in which facing nodes are held: normals of folded surfaces say nothing.
    const double pull = !collision.at_nodes() || contacts.facing
                            ? -force
                            : -nodal.segment<3>(3 * slave).dot(detector.pair(slave, x).normal);
    record.largest_multiplier = record.rows == 1 ? pull : std::max(record.largest_multiplier, pull);
  }
  record.force_first = sum_of_forces(detector.first(), detector.second(), nodal);
  record.force_second = sum_of_forces(detector.second(), detector.first(), nodal);
  if (record.rows > 0) {
    const Pressed both =
        measure(collision.pressed(detector.first(), now, x), collision.pressed(detector.second(), now, x));
    record.area = both.area;
    record.length = both.length;
    record.peak_pressure = both.peak;
  }
  record.deepest_gap = contacts.facing ? collision.facing()->deepest(x) : detector.deepest(x, reach).gap;
  record.overlap_volume = detector.overlap_volume(x, reach);
  for (const EdgeCrossing& crossing : detector.edge_crossings(x, reach))
    record.edge_overlap_volume += crossing.volume;
  return record;
}

}  // namespace plica

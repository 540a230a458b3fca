#include "plica/dynamics/mirror_contact.hpp"

#include <algorithm>
#include <cmath>

#include "plica/core/error.hpp"
#include "plica/dynamics/contact_record.hpp"

namespace plica {

namespace {

void check(const ContactPart& part) {
  const auto refuse = [](const std::string& what) {
    throw InvalidInput("Reduction: with symmetry " + what + " Leave symmetry out, or choose another contact.");
  };
  const auto* multipliers = std::get_if<Multipliers>(&part.enforcement);
  if (!multipliers || !std::holds_alternative<EndOfStep>(multipliers->position))
    refuse("contact must be by multipliers, its gaps closed at the end of the step.");
  if (part.friction) refuse("contact.friction must be left out: mirror images do not slide past each other.");
  if (part.surface_mass != SurfaceMass::kept)
    refuse("contact.surface_mass = \"redistributed\"; must be \"kept\".");
  if (part.airway.renewed) refuse("contact.airway = \"triangulated\"; must be \"matched\".");
  if (!std::holds_alternative<AtNodes>(part.faces)) refuse("contact.faces = \"mortar\"; must be \"nodes\".");
  if (!(std::abs(part.airway.facing[0]) > 1 - 1e-9))
    refuse("contact.direction must be along x, across the plane between the mirror images.");
}

}  // namespace

MirrorContact::MirrorContact(const Scene& scene, const Motion& full, const ModalMotion& motion)
    : motion_(motion),
      images_(*full.images()),
      mesh_nodes_(full.reference().rows()),
      side_((check(*scene.contact), *scene.contact), full, motion) {
  const Points& reference = full.reference();
  tolerance_ = scene.contact->options.tolerance * side_.surface().mean_edge(reference);
  const std::vector<std::int32_t> crossing = side_.crossing();
  nodes_ = Eigen::Map<const Indices>(crossing.data(), static_cast<std::ptrdiff_t>(crossing.size()));
  copies_.resize(nodes_.size());
  for (std::ptrdiff_t i = 0; i < nodes_.size(); ++i) copies_[i] = images_.count(images_.node_of(nodes_[i]));
  const Eigen::MatrixXd shapes = motion.shapes_at(nodes_)(Eigen::seqN(0, nodes_.size(), 3), Eigen::all);
  x_ = DistantValues(reference(nodes_, 0), shapes);
  loads_ = shapes.transpose() * copies_.asDiagonal();
  accelerations_ = motion.inverse() * loads_;
  compliance_ = shapes * accelerations_;
}

void MirrorContact::begin(const State& last) {
  last_ = &last;
  load_ = acceleration_ = Vector::Zero(motion_.size());
  force_ = Vector::Zero(3 * nodes_.size());
  row_force_ = Vector::Zero(nodes_.size());
  rows_ = last.closed;
  active_.assign(rows_.size(), 1);
  touches_ = false;
  passes_ = pivots_ = 0;
}

void MirrorContact::touch(const Vector& free) {
  touches_ = false;
  free_ = free;
  x_.move(free);
  row_force_.setZero();
  deepest_ = 0;
  Vector shift = Vector::Zero(nodes_.size());
  for (bool more = add_candidates(shift, 0.0) || !rows_.empty(); more;
       more = add_candidates(shift, 1e-2 * tolerance_)) {
    Vector x(static_cast<std::ptrdiff_t>(rows_.size()));
    for (std::ptrdiff_t i = 0; i < x.size(); ++i) x[i] = x_.value(rows_[static_cast<std::size_t>(i)]);
    const Complementarity found = solve(x);
    ++passes_;
    pivots_ += found.pivots;
    active_ = found.active;
    row_force_.setZero();
    row_force_(rows_) = found.force;
    shift.setZero();
    for (const std::int32_t row : rows_)
      if (row_force_[row] > 0) shift += inertia() * row_force_[row] * compliance_.col(row);
    deepest_ = std::min(0.0, (x + shift(rows_)).minCoeff());
  }
  force_.setZero();
  load_.setZero();
  acceleration_.setZero();
  for (const std::int32_t row : rows_) {
    const double force = row_force_[row];
    if (!(force > 0)) continue;
    touches_ = true;
    force_[3 * static_cast<std::ptrdiff_t>(row)] = force;
    load_ += force * loads_.col(row);
    acceleration_ += force * accelerations_.col(row);
  }
}

bool MirrorContact::add_candidates(const Vector& shift, double least) {
  const std::size_t known = rows_.size();
  const Vector at_least = x_.at_least() + shift;
  if (at_least.minCoeff() >= -least) return false;
  for (std::int32_t row = 0; row < shift.size(); ++row) {
    if (at_least[row] >= -least || x_.value(row) + shift[row] >= -least) continue;
    const auto at = std::lower_bound(rows_.begin(), rows_.end(), row);
    if (at != rows_.end() && *at == row) continue;
    active_.insert(active_.begin() + (at - rows_.begin()), 1);
    rows_.insert(at, row);
  }
  return rows_.size() > known;
}

/// 0 <= f, 0 <= x + h^2 beta X A^-1 X^T c f: with sqrt(c) of each the matrix is symmetric.
Complementarity MirrorContact::solve(const Vector& x) const {
  constexpr int most_pivots = 1000;
  const Vector root = copies_(rows_).cwiseSqrt();
  const Eigen::MatrixXd W = inertia() * (root.asDiagonal() * Eigen::MatrixXd(compliance_(rows_, rows_)) *
                                         root.cwiseInverse().asDiagonal());
  Complementarity found = solve_complementarity(W, root.cwiseProduct(x), active_, 1e-2 * tolerance_, most_pivots);
  if (!found.converged)
    throw SolveFailed("Contact: no consistent set of closed nodes among " + std::to_string(rows_.size()) +
                      " after " + std::to_string(found.pivots) + " active sets. Try a smaller step.");
  found.force = found.force.cwiseQuotient(root);
  return found;
}

std::pair<std::vector<std::int32_t>, Vector> MirrorContact::closed() const {
  std::vector<std::int32_t> keys;
  if (touches_)
    for (const std::int32_t row : rows_)
      if (row_force_[row] > 0) keys.push_back(row);
  const Vector force = row_force_(keys);
  return {std::move(keys), force};
}

bool MirrorContact::anywhere(const std::function<bool(const Vector3&)>& place) const {
  if (!touches_) return false;
  const Vector q = free_ + inertia() * acceleration_;
  for (const std::int32_t row : rows_) {
    if (!(row_force_[row] > 0)) continue;
    const Vector3 x = side_.position(nodes_[row], q);
    for (const double ahead : {1.0, -1.0})
      if ((ahead > 0 || images_.planes() > 1) && place(Vector3(0.0, ahead * x[1], x[2]))) return true;
  }
  return false;
}

ContactRecord MirrorContact::record(const State& now) {
  ContactRecord record;
  record.passes = passes_;
  record.pivots = pivots_;
  pressed_.clear();
  if (passes_ == 0) return record;
  record.deepest_gap = 2 * deepest_;
  record.gap_error = -record.deepest_gap;
  record.converged = -deepest_ <= tolerance_;
  if (!touches_) return record;
  pressed_ = side_.pressed(nodes_, row_force_, now.displacement);
  double sum = 0;
  record.largest_multiplier = -row_force_.maxCoeff();
  for (const std::int32_t row : rows_) {
    const double force = row_force_[row];
    if (!(force > 0)) continue;
    const double copies = copies_[row] / 2;  // on one side
    record.rows += static_cast<int>(copies);
    sum += copies * force;
    record.largest_multiplier = std::max(record.largest_multiplier, -force);
  }
  record.force_first = (side_.is_first() ? 1.0 : -1.0) * sum * Vector3::UnitX();
  record.force_second = -record.force_first;
  const Pressed both = measure(pressed_, pressed_);
  record.area = both.area;
  record.length = both.length;
  record.peak_pressure = both.peak;
  return record;
}

void MirrorContact::restore(const State& state) {
  Vector force = Vector::Zero(nodes_.size());
  force(state.closed) = state.closed_force;
  pressed_ = side_.pressed(nodes_, force, state.displacement);
}

Vector MirrorContact::pressure() const {
  Vector everywhere = Vector::Zero(mesh_nodes_);
  for (const PressedNode& node : pressed_)
    everywhere[node.node] = everywhere[images_.partner(0, node.node)] = node.pressure;
  return everywhere;
}

Vector MirrorContact::force(const Vector& interface_force) const {
  Vector part = Vector::Zero(3 * images_.nodes().size());
  for (std::ptrdiff_t i = 0; i < nodes_.size(); ++i)
    part.segment<3>(3 * static_cast<std::ptrdiff_t>(images_.node_of(nodes_[i]))) =
        interface_force.segment<3>(3 * i);
  return images_.spread(part);
}

}  // namespace plica

#include "plica/dynamics/mirror_contact.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "plica/core/error.hpp"
#include "plica/core/panel_matrix.hpp"
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
  if (part.airway.renewed) refuse("contact.airway = \"triangulated\"; must be \"matched\".");
  if (!std::holds_alternative<AtNodes>(part.faces)) refuse("contact.faces = \"mortar\"; must be \"nodes\".");
  if (!(std::abs(part.airway.facing[0]) > 1 - 1e-9))
    refuse("contact.direction must be along x, across the plane between the mirror images.");
}

/// Whether a surface lies in x >= 0, judged by where most of it is.
bool is_own(const Triangles& side, const Points& x) {
  double sum = 0;
  for (const std::int32_t node : side.reshaped()) sum += x(node, 0);
  return sum > 0;
}

}  // namespace

MirrorContact::MirrorContact(const Scene& scene, const Motion& full, const ModalMotion& motion)
    : motion_(motion), images_(*full.images()), reference_(full.reference()) {
  const ContactPart& part = *scene.contact;
  check(part);
  first_is_own_ = is_own(part.airway.first, reference_);
  if (first_is_own_ == is_own(part.airway.second, reference_))
    throw InvalidInput(
        "Reduction: with symmetry the contact's surfaces must be each other's mirror image in x = 0.");
  side_.emplace(first_is_own_ ? part.airway.first : part.airway.second, reference_.rows());
  tolerance_ = part.options.tolerance * side_->mean_edge(reference_);
  const std::vector<std::int32_t> own = own_nodes(part, full);
  nodes_ = Eigen::Map<const Indices>(own.data(), static_cast<std::ptrdiff_t>(own.size()));
  images_of_.resize(nodes_.size());
  for (std::ptrdiff_t i = 0; i < nodes_.size(); ++i) images_of_[i] = images_.count(images_.node_of(nodes_[i]));
  const Eigen::MatrixXd shapes = motion.shapes_at(nodes_)(Eigen::seqN(0, nodes_.size(), 3), Eigen::all);
  x_ = DistantValues(reference_(nodes_, 0), shapes);
  loads_ = shapes.transpose() * images_of_.asDiagonal();
  accelerations_ = motion.inverse() * loads_;
  compliance_ = shapes * accelerations_;
  const Indices of_side =
      Eigen::Map<const Indices>(side_->nodes().data(), static_cast<std::ptrdiff_t>(side_->nodes().size()));
  side_shapes_ = motion.shapes_at(of_side).transpose();
  place_.assign(static_cast<std::size_t>(reference_.rows()), -1);
  for (std::int32_t i = 0; i < of_side.size(); ++i) place_[static_cast<std::size_t>(of_side[i])] = i;
}

std::vector<std::int32_t> MirrorContact::own_nodes(const ContactPart& part, const Motion& full) const {
  std::vector<std::int32_t> found;
  for (const std::int32_t node : side_->nodes()) {
    const std::int32_t own = images_.node_of(node);
    // What lies in the plane is held there, or common to both surfaces: it neither opens nor closes.
    if (images_.nodes()[own] == node && !full.supports().fixed(3 * static_cast<std::ptrdiff_t>(own)))
      found.push_back(node);
  }
  if (found.empty())
    throw InvalidInput("Reduction: no node of the contact's surfaces can move across the plane x = 0; one must.");
  const ContactSurface other(first_is_own_ ? part.airway.second : part.airway.first, reference_.rows());
  for (const std::int32_t node : found)
    if (!other.contains(images_.partner(0, node)))
      throw InvalidInput("Reduction: with symmetry the mirror image of node " + std::to_string(node) +
                         " in x = 0 must be on the contact's other surface; is not.");
  return found;
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
  const Vector root = images_of_(rows_).cwiseSqrt();
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

Vector3 MirrorContact::position(std::int32_t node, const Vector& q) const {
  const std::ptrdiff_t at = 3 * static_cast<std::ptrdiff_t>(place_[static_cast<std::size_t>(node)]);
  Vector3 x = reference_.row(node);
  for (int c = 0; c < 3; ++c) x[c] += inner_product(side_shapes_.col(at + c).data(), q.data(), q.size());
  return x;
}

bool MirrorContact::anywhere(const std::function<bool(const Vector3&)>& place) const {
  if (!touches_) return false;
  const Vector q = free_ + inertia() * acceleration_;
  for (const std::int32_t row : rows_) {
    if (!(row_force_[row] > 0)) continue;
    const Vector3 x = position(nodes_[row], q);
    for (const double ahead : {1.0, -1.0})
      if ((ahead > 0 || images_.planes() > 1) && place(Vector3(0.0, ahead * x[1], x[2]))) return true;
  }
  return false;
}

std::vector<PressedNode> MirrorContact::pressed(const Vector& force, const Vector& q) const {
  std::vector<PressedNode> found;
  Points x(reference_.rows(), 3);  // of the nodes around those that are pressed
  std::vector<char> known(static_cast<std::size_t>(reference_.rows()), 0);
  for (std::int32_t row = 0; row < force.size(); ++row) {
    if (!(force[row] > 0)) continue;
    const std::int32_t node = nodes_[row];
    double area = 0;
    for (const std::int32_t triangle : side_->fan(node)) {
      const auto corners = side_->triangles().row(triangle);
      for (const std::int32_t corner : corners)
        if (char& is_known = known[static_cast<std::size_t>(corner)]; !is_known) {
          x.row(corner) = position(corner, q);
          is_known = 1;
        }
      const Vector3 a = x.row(corners[0]), b = x.row(corners[1]), c = x.row(corners[2]);
      area += (b - a).cross(c - a).norm() / 6.0;
    }
    const auto [from, to] = side_->tributary_stretch(node, x);
    found.push_back({node, area, force[row] / area, {from, to}});
    if (images_.planes() > 1 && images_.partner(1, node) != node)
      found.push_back({images_.partner(1, node), area, force[row] / area, {-to, -from}});
  }
  return found;
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
  pressed_ = pressed(row_force_, now.displacement);
  double sum = 0;
  record.largest_multiplier = -row_force_.maxCoeff();
  for (const std::int32_t row : rows_) {
    const double force = row_force_[row];
    if (!(force > 0)) continue;
    const double copies = images_of_[row] / 2;  // on one side
    record.rows += static_cast<int>(copies);
    sum += copies * force;
    record.largest_multiplier = std::max(record.largest_multiplier, -force);
  }
  record.force_first = (first_is_own_ ? 1.0 : -1.0) * sum * Vector3::UnitX();
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
  pressed_ = pressed(force, state.displacement);
}

Vector MirrorContact::pressure() const {
  Vector everywhere = Vector::Zero(reference_.rows());
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

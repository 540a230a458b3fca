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
  if (part.surface_mass != SurfaceMass::kept)
    refuse("contact.surface_mass = \"redistributed\"; must be \"kept\".");
  if (part.airway.renewed) refuse("contact.airway = \"triangulated\"; must be \"matched\".");
  if (!std::holds_alternative<AtNodes>(part.faces)) refuse("contact.faces = \"mortar\"; must be \"nodes\".");
  if (!(std::abs(part.airway.facing[0]) > 1 - 1e-9))
    refuse("contact.direction must be along x, across the plane between the mirror images.");
}

}  // namespace

MirrorContact::MirrorContact(const Scene& scene, const Motion& full, const ModalMotion& motion,
                             const Mediolateral& positions)
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
  const std::ptrdiff_t rows = nodes_.size();  // Mediolateral's contact nodes, in that order
  for (std::ptrdiff_t i = 0; i < rows; ++i)
    if (positions.contact_size() != rows || positions.place(nodes_[i]) != i)
      throw InvalidInput(
          "Reduction: with symmetry each of the contact's surfaces must lie on its own side of the plane x = 0.");
  loads_ = positions.shapes().topRows(rows).transpose() * copies_.asDiagonal();
  accelerations_ = motion.inverse() * loads_;
  x_accelerations_ = positions.shapes() * accelerations_;
  // 0 <= f, 0 <= x + h^2 beta X A^-1 X^T c f: with sqrt(c) of each row the matrix is symmetric.
  const Vector root = copies_.cwiseSqrt();
  compliance_ =
      inertia() * (root.asDiagonal() * x_accelerations_.topRows(rows) * root.cwiseInverse().asDiagonal());
  least_compliance_ = shared_compliance * compliance_.diagonal().maxCoeff();
}

void MirrorContact::begin(const State& last) {
  row_force_ = Vector::Zero(nodes_.size());
  rows_ = last.closed;
  active_.assign(rows_.size(), 1);
  touches_ = false;
  passes_ = pivots_ = 0;
}

void MirrorContact::touch(const FreeEnd& free) {
  touches_ = false;
  free_ = &free;
  row_force_.setZero();
  deepest_ = 0;
  const Vector& x_free = free.contact_x();
  if (!x_free.allFinite()) throw SolveFailed("Contact: positions are not finite. Did the time step diverge?");
  if (rows_.empty() && !(x_free.minCoeff() < 0)) return;
  Vector x = x_free;
  for (bool more = add_candidates(x, 0.0) || !rows_.empty(); more; more = add_candidates(x, 1e-2 * tolerance_)) {
    const Complementarity found = solve(x_free(rows_));
    ++passes_;
    pivots_ += found.pivots;
    active_ = found.active;
    row_force_.setZero();
    row_force_(rows_) = found.force;
    x_acceleration_ = of_forces(x_accelerations_);
    x = x_free + inertia() * x_acceleration_.head(x.size());
    deepest_ = std::min(0.0, x(rows_).minCoeff());
  }
  touches_ = (row_force_.array() > 0).any();
}

Vector MirrorContact::of_forces(const Eigen::MatrixXd& columns) const {
  Vector sum = Vector::Zero(columns.rows());
  for (const std::int32_t row : rows_)
    if (row_force_[row] > 0) sum += row_force_[row] * columns.col(row);
  return sum;
}

Vector MirrorContact::interface_force() const {
  Vector force = Vector::Zero(3 * nodes_.size());
  for (std::ptrdiff_t row = 0; row < nodes_.size(); ++row) force[3 * row] = std::max(row_force_[row], 0.0);
  return force;
}

bool MirrorContact::add_candidates(const Vector& x, double least) {
  if (x.minCoeff() >= -least) return false;
  const std::size_t known = rows_.size();
  for (std::int32_t row = 0; row < x.size(); ++row) {
    if (x[row] >= -least) continue;
    const auto at = std::lower_bound(rows_.begin(), rows_.end(), row);
    if (at != rows_.end() && *at == row) continue;
    active_.insert(active_.begin() + (at - rows_.begin()), 1);
    rows_.insert(at, row);
  }
  return rows_.size() > known;
}

Complementarity MirrorContact::solve(const Vector& x) {
  constexpr int most_pivots = 1000;
  const Vector root = copies_(rows_).cwiseSqrt(), scaled = root.cwiseProduct(x);
  std::vector<std::int32_t> closed;
  std::vector<std::ptrdiff_t> places;  // of these among the candidates
  const auto gaps_closed = [&](const std::vector<char>& active, Vector& p, Vector& w) {
    closed.clear();
    places.clear();
    for (std::size_t i = 0; i < active.size(); ++i)
      if (active[i]) {
        closed.push_back(rows_[i]);
        places.push_back(static_cast<std::ptrdiff_t>(i));
      }
    p.setZero();
    w = scaled;
    if (closed.empty()) return;
    if (closed != factored_) {
      Eigen::MatrixXd W = compliance_(closed, closed);
      W.diagonal().array() += least_compliance_;
      factor_.compute(W);
      factored_ = closed;
      if (factor_.info() != Eigen::Success) factored_.clear();
    }
    if (factored_.empty())
      throw SolveFailed("Contact: the compliance of the closed nodes is not positive. Try a smaller step.");
    const Vector force = factor_.solve(-scaled(places));
    p(places) = force;
    w.noalias() += compliance_(rows_, closed) * force;
    w(places).setZero();
  };
  Complementarity found = pivot(active_, gaps_closed, 1e-2 * tolerance_, most_pivots);
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
  const Vector q = free_->free_end() + inertia() * acceleration();
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

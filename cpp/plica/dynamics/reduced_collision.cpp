#include "plica/dynamics/reduced_collision.hpp"

#include <algorithm>

#include "plica/core/error.hpp"
#include "plica/dynamics/contact_record.hpp"

namespace plica {

namespace {

/// Triangles or tetrahedra in the numbers of `local`.
template <typename Rows>
Rows renumbered(Rows rows, const std::vector<std::int32_t>& local) {
  for (std::int32_t& node : rows.reshaped()) node = local[static_cast<std::size_t>(node)];
  return rows;
}

constexpr double tightest_in_single =
    1e-6;                       // tolerance, in edges; a step moves less than an edge, by 6e-8 of it off
constexpr int least_rings = 1;  // of triangles around what is near

void check(const ContactPart& part) {
  const auto refuse = [](const char* what) {
    throw InvalidInput(std::string("Reduction: ") + what + " Leave the reduction out, or choose another contact.");
  };
  if (part.airway.renewed) refuse("contact.airway = \"triangulated\"; must be \"matched\".");
  if (part.surface_mass != SurfaceMass::kept)
    refuse("contact.surface_mass = \"redistributed\"; must be \"kept\".");
  if (!std::holds_alternative<AtNodes>(part.faces)) refuse("contact.faces = \"mortar\"; must be \"nodes\".");
  if (std::holds_alternative<Nitsche>(part.enforcement))
    refuse("contact by Nitsche's method sees the whole tissue.");
}

}  // namespace

ReducedCollision::ReducedCollision(const Scene& scene, const Motion& full, const ModalMotion& motion,
                                   const Mediolateral& positions)
    : motion_(motion),
      mediolateral_(positions),
      mesh_nodes_(scene.mesh.node_count()),
      single_(scene.contact->options.tolerance >= tightest_in_single) {
  const ContactPart& part = *scene.contact;
  check(part);
  by_nodes_ = !std::holds_alternative<VolumePenalty>(part.enforcement);
  const std::vector<std::int32_t> nodes = surface_nodes(part.airway);
  std::vector<std::int32_t> local(static_cast<std::size_t>(mesh_nodes_), -1);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    local[static_cast<std::size_t>(nodes[i])] = static_cast<std::int32_t>(i);
  nodes_ = Eigen::Map<const Indices>(nodes.data(), static_cast<std::ptrdiff_t>(nodes.size()));
  const Airway airway{renumbered(part.airway.first, local), renumbered(part.airway.second, local),
                      renumbered(part.airway.tets, local), nullptr, part.airway.facing};
  reference_ = full.reference()(nodes_, Eigen::all);
  shapes_ = motion.shapes_at(nodes_);
  auto solver = std::make_unique<ModalForceSolver>(motion, shapes_, single_);
  force_solver_ = solver.get();
  collision_.emplace(airway, reference_, contact_method(part.enforcement), part.friction, part.options,
                     std::move(solver), part.faces);
  proximity_.emplace(airway, reference_, shapes_);
  everywhere_detector_.emplace(airway, reference_);
  ahead_ = 0.004 * collision_->detector().mean_edge();
  x_before_ = x_first_ = x_free_ = x_ = at_end_ = reference_;
  look_everywhere();
}

void ReducedCollision::take_first_positions() {
  if (first_free_.size() > 0) seen_.move(reference_, first_free_, x_first_);
}

const Points& ReducedCollision::ends(const Vector& q) {
  if (end_.size() == 0 || q != end_) {
    seen_.move(reference_, q, at_end_);
    end_ = q;
  }
  return at_end_;
}

void ReducedCollision::look_everywhere() {
  everywhere_ = shown_is_near_ = true;
  seen_ = MovedNodes(Indices::LinSpaced(nodes_.size(), 0, static_cast<std::int32_t>(nodes_.size()) - 1), shapes_);
  collision_->detector().look_everywhere();
  force_solver_->look_at(seen_);
  end_.resize(0);
  take_first_positions();
}

void ReducedCollision::look(const Vector& q, double ahead, int rings) {
  static const std::vector<std::int32_t> none;
  proximity_->choose(q, ahead, by_nodes_ ? last_->closed : none);
  moves_ = 0;
  shown_is_near_ = !by_nodes_ || proximity_->everything();
  rings_ = rings;
}

void ReducedCollision::show_near() {
  if (shown_is_near_) return;
  shown_is_near_ = true;
  everywhere_ = false;
  const Neighbourhood part = proximity_->surroundings(rings_);
  Detector& detector = collision_->detector();
  detector.look_at(part);
  std::vector<char> taken(static_cast<std::size_t>(nodes_.size()), 0);
  const auto take = [&](const ContactSurface& side, const std::vector<std::int32_t>& triangles) {
    for (const std::int32_t t : triangles)
      for (const std::int32_t node : side.triangles().row(t)) taken[static_cast<std::size_t>(node)] = 1;
  };
  take(detector.first(), part.first);
  take(detector.second(), part.second);
  Indices nodes(std::count(taken.begin(), taken.end(), 1));
  for (std::int32_t node = 0, i = 0; node < nodes_.size(); ++node)
    if (taken[static_cast<std::size_t>(node)]) nodes[i++] = node;
  seen_ = MovedNodes(std::move(nodes), shapes_);
  force_solver_->look_at(seen_);
  end_.resize(0);
  take_first_positions();
}

void ReducedCollision::keep_in_sight(const Vector& q) {
  constexpr int lasting = 16;  // moves with contact: what was near is left behind after more, a look costs as few
  const auto in_sight = [&](std::int32_t key) { return !by_nodes_ || proximity_->is_near(key); };
  const bool holds = proximity_->holds_at(q) && std::all_of(last_->closed.begin(), last_->closed.end(), in_sight);
  if (holds && (moves_ < lasting || !by_nodes_)) return;
  const double edge = collision_->detector().mean_edge();
  if (holds)
    ahead_ = std::max(ahead_ / 1.2, 0.002 * edge);
  else if (moves_ > 0 && moves_ < lasting / 2)
    ahead_ = std::min(1.5 * ahead_, edge);
  look(q, ahead_, least_rings);
}

void ReducedCollision::begin(const State& last) {
  last_ = &last;
  near_ = false;
  never_near_ = true;
  contacts_ = {};
  force_ = Vector::Zero(3 * nodes_.size());
  load_ = acceleration_ = Vector::Zero(motion_.size());
  collision_->forget();
  first_free_.resize(0);
}

void ReducedCollision::touch(const FreeEnd& move) {
  constexpr int most_looks = 5;
  const Vector free = move.free_end();
  const Contacts known = std::move(contacts_);
  contacts_ = {};
  touches_ = false;
  force_.setZero();
  load_.setZero();
  acceleration_.setZero();
  keep_in_sight(free);
  near_ = !last_->closed.empty() || proximity_->can_touch(free);
  if (!near_) return;
  never_near_ = false;
  ++moves_;
  Detector& detector = collision_->detector();
  int rings = least_rings;
  for (int looks = 1;; ++looks) {
    show_near();
    detector.take_foot_on_rim();
    contacts_ = solve(free, known);
    force_solver_->respond(contacts_.rows, contacts_.force);
    reach_ = 2 * (proximity_->moved(free - last_->displacement) + force_solver_->farthest_shift()) + last_->depth;
    const Vector moved = inertia() * force_solver_->acceleration();
    const bool on_rim = detector.take_foot_on_rim() && !everywhere_;
    // Forces may have moved what was further away.
    const bool holds = everywhere_ || !contacts_.any_force() || proximity_->holds_at(free + moved);
    if (!on_rim && holds) break;
    if (on_rim) ++rings;
    if (!holds) ahead_ = std::max(1.5 * ahead_, 1.1 * proximity_->closed(moved));
    if (looks < most_looks)
      look(free, ahead_, rings);
    else
      look_everywhere();
  }
  touches_ = contacts_.any_force();
  if (!touches_) return;
  contacts_.add_forces(force_);
  load_ = force_solver_->load();
  acceleration_ = force_solver_->acceleration();
  x_acceleration_ = mediolateral_.change(acceleration_);
}

Contacts ReducedCollision::solve(const Vector& free, Contacts known) {
  x_before_ = ends(last_->displacement);
  if (first_free_.size() == 0) {
    first_free_ = free;
    take_first_positions();
  }
  if (single_)
    seen_.move_single(x_first_, free - first_free_, x_free_);
  else
    seen_.move(x_first_, free - first_free_, x_free_);
  const double weight = 1 + motion_.scheme().alpha, alpha = motion_.scheme().alpha;
  const bool at_end = std::holds_alternative<EndOfStep>(collision_->method().position());
  const double scale = at_end ? 1.0 : weight;
  force_solver_->begin();
  const BeforeContact before{x_before_,    last_->closed, last_->closed_force,
                             last_->depth, nullptr,       scale * proximity_->moved(free - last_->displacement)};
  if (at_end) return collision_->solve(x_free_, inertia(), before, std::move(known), x_);
  const Points weighted = weight * x_free_ - alpha * x_before_;
  Contacts contacts = collision_->solve(weighted, weight * inertia(), before, std::move(known), x_);
  x_ = (x_ + alpha * x_before_) / weight;
  return contacts;
}

bool ReducedCollision::anywhere(const std::function<bool(const Vector3&)>& place) const {
  if (!near_) return false;
  for (std::size_t i = 0; i < contacts_.constraints.size(); ++i)
    if (contacts_.force[static_cast<std::ptrdiff_t>(i)] > 0 && place(x_.row(contacts_.constraints[i].slave)))
      return true;
  const Detector& detector = collision_->detector();
  const auto crossings = detector.edge_crossings(x_, reach_);
  return std::any_of(crossings.begin(), crossings.end(),
                     [&](const EdgeCrossing& crossing) { return place(crossing.place); });
}

ContactRecord ReducedCollision::record(const State& now) {
  if (never_near_) {
    pressure_.resize(0);
    return {};
  }
  const Contact contact = now.contact_at_interface();
  const double reach = 2 * proximity_->moved(now.displacement - last_->displacement) + last_->depth;
  ContactRecord record;
  do {
    collision_->detector().take_foot_on_rim();
    const Points before = ends(last_->displacement), &x = ends(now.displacement);
    collision_->update(x);
    pressure_ = collision_->pressure(contact, x);
    record = contact_record(*collision_, contacts_, before, reach, contact, x);
  } while (collision_->detector().take_foot_on_rim() && !everywhere_ && (look_everywhere(), true));
  return record;
}

void ReducedCollision::restore(const State& state) {
  watched_.resize(0);
  look_everywhere();
  const Points& x = ends(state.displacement);
  collision_->update(x);
  pressure_ = collision_->pressure(state.contact_at_interface(), x);
}

Vector ReducedCollision::pressure() const {
  Vector everywhere = Vector::Zero(mesh_nodes_);
  if (pressure_.size() > 0) everywhere(nodes_) = pressure_;
  return everywhere;
}

Vector ReducedCollision::force(const Vector& interface_force) const {
  Points force = Points::Zero(mesh_nodes_, 3);
  force(nodes_, Eigen::all) = as_points(interface_force);
  return as_vector(force);
}

void ReducedCollision::require_open_beyond(const State& now, const Points& x) {
  if (proximity_->everything()) return;
  if (watched_.size() == 0) watched_ = Vector::Zero(motion_.size());
  Detector& detector = *everywhere_detector_;
  const double reach = 2 * proximity_->moved(now.displacement - watched_) + now.depth;
  const Points at = x(nodes_, Eigen::all);
  detector.update(at);
  for (const ContactSurface* side : {&detector.first(), &detector.second()})
    for (const Pair& pair : detector.inside(*side, at, reach))
      if (!proximity_->is_near(pair.slave))
        throw SolveFailed("Reduction: the surfaces have passed through each other at node " +
                          std::to_string(nodes_[pair.slave]) + " (" + number_text(at(pair.slave, 0)) + ", " +
                          number_text(at(pair.slave, 1)) + ", " + number_text(at(pair.slave, 2)) +
                          ") m, where they slid past each other more steeply than contact is looked for. Leave "
                          "the reduction out.");
  watched_ = now.displacement;  // of what was refused the next look is still at all that moved since
}

}  // namespace plica

#include "plica/contact/collision.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "plica/contact/friction.hpp"
#include "plica/core/error.hpp"
#include "plica/core/stopwatch.hpp"

namespace plica {

namespace {

constexpr double acceptable = 10;  // tolerances, of the gap error that an unconverged step may have

/// The constraint that is furthest from complementarity.
struct Worst {
  double off = 0.0;  // m
  const Constraint* constraint = nullptr;
};
Worst worst_of(const ContactMethod& method, const std::vector<Constraint>& constraints, const Contacts& last,
               const Points& x) {
  Worst worst{0.0, constraints.data()};
  for (const Constraint& constraint : constraints)
    if (const double off = method.violation(constraint, last.force_of(constraint.key), x); off > worst.off)
      worst = {off, &constraint};
  return worst;
}

/// Why passes that settle nothing have ended after so many.
std::string stopped_without_settling(int passes, const ContactMethod& method,
                                     const std::vector<Constraint>& constraints, const Contacts& last,
                                     const Points& x, double tolerance) {
  const Worst worst = worst_of(method, constraints, last, x);
  if (!worst.constraint)
    return "Contact: none of " + std::to_string(passes) + " passes settled. Try a smaller step.";
  const std::int32_t node = worst.constraint->slave;
  return "Contact: gap error " + number_text(worst.off) + " m after " + std::to_string(passes) +
         " passes (tolerance " + number_text(tolerance) + " m), worst at node " + std::to_string(node) + " " +
         place_text(x.row(node)) + ". Try a smaller step, more passes, or a larger tolerance.";
}

/// Of the passes since the last new candidate the one that came closest, and how they come closer.
struct BestPass {
  struct Pass {
    Contacts contacts;
    Points x;  // (n, 3) m, that they lead to
  };
  std::optional<Pass> pass;
  int halved = 0;  // the pass that last halved the gap error
  double halved_error = std::numeric_limits<double>::infinity();

  bool within(double gap_error) const { return pass && pass->contacts.gap_error <= gap_error; }
  void take(int number, const Contacts& contacts, const Points& x) {
    if (!pass || contacts.gap_error < pass->contacts.gap_error) pass = Pass{contacts, x};
    if (2 * contacts.gap_error <= halved_error) halved = number, halved_error = contacts.gap_error;
  }
};

/// Which constraints to take for closed at first: those that press, and those that are inside.
std::vector<char> first_guess(const std::vector<Constraint>& constraints, const Contacts& last,
                              const std::vector<std::int32_t>& closed_before, const Points& x) {
  std::vector<char> guess;
  guess.reserve(constraints.size());
  for (const Constraint& constraint : constraints) {
    const bool pressed = last.constraints.empty()
                             ? std::binary_search(closed_before.begin(), closed_before.end(), constraint.key)
                             : last.force_of(constraint.key) > 0;
    guess.push_back(pressed || constraint.gap(x) < 0);
  }
  return guess;
}

/// The last pass's forces along the normals and tangents of these constraints, (3 x constraints) N.
Vector last_friction(const std::vector<Constraint>& constraints, const Contacts& last) {
  const auto count = static_cast<std::ptrdiff_t>(constraints.size());
  const auto before = static_cast<std::ptrdiff_t>(last.constraints.size());
  Vector force = Vector::Zero(3 * count);
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const std::ptrdiff_t k = last.place_of(constraints[static_cast<std::size_t>(i)].key);
    if (k < 0) continue;
    force[i] = last.force[k];
    force.segment<2>(count + 2 * i) = last.force.segment<2>(before + 2 * k);
  }
  return force;
}

}  // namespace

void Collision::Options::validate() const {
  if (!(tolerance > 0 && tolerance < 1))
    throw InvalidInput("Contact", "tolerance", tolerance, "mean edges", "in (0, 1)");
  if (max_passes < 1) throw InvalidInput("Contact", "max_passes", max_passes, "", ">= 1");
}

Collision::Collision(Airway airway, const Points& reference, std::unique_ptr<ContactMethod> method,
                     std::optional<Friction> friction, Options options, std::unique_ptr<ForceSolver> solver,
                     const FaceMethod& faces)
    : detector_(std::move(airway), reference),
      method_(std::move(method)),
      friction_(friction),
      options_(options),
      at_nodes_(std::holds_alternative<AtNodes>(faces)),
      force_solver_(std::move(solver)) {
  options_.validate();
  if (friction_) {
    require_positive("friction", friction_->coefficient, "");
    if (!method_->takes_friction())
      throw InvalidInput(
          "Contact: friction; must come with multipliers and the condensed solver, or with augmented "
          "multipliers.");
  }
  kind_ = method_->kind(detector_, faces);
}

void Collision::hold_facing(const Points& reference, bool images) {
  if (!method_->exact() || !at_nodes_ || friction_) return;
  facing_.emplace(detector_, reference);
  if (facing_->empty()) facing_.reset();
  facing_are_images_ = images && facing_;
}

std::vector<Constraint> Collision::constraints_at(const Search& search, const Points& x) {
  constexpr int settle_from = 20;  // what need not settle is held in one direction from then on
  const Stopwatch watch(detection_time_);
  std::vector<Constraint> constraints;
  constraints.reserve(search.keys.size());
  for (const std::int32_t key : search.keys) {
    Constraint constraint = kind_->at(key, x, search.reach);
    const std::ptrdiff_t known = search.passes >= settle_from ? search.last.place_of(key) : -1;
    const Constraint* before = known < 0 ? nullptr : &search.last.constraints[static_cast<std::size_t>(known)];
    // A mean over a sliver comes and goes as its force does, and never settles.
    if (before && before->sliver() && (constraint.key < 0 || constraint.sliver())) constraint = *before;
    if (constraint.key < 0) continue;
    // What was left inside is held there: to close it at a stroke would do work which nothing pays for. Where
    // nothing was inside, as at rest, all is closed.
    if (!(search.before.depth > 0)) constraint.depth = 0;
    method_->complete(constraint, detector_);
    // Seen from behind a ridge, too, the foot jumps from face to face.
    if (before && (constraint.depth > 0 || constraint.beside(x, tolerance()))) constraint.keep_direction(*before);
    constraints.push_back(std::move(constraint));
  }
  return constraints;
}

void Collision::update(const Points& x) {
  const Stopwatch watch(detection_time_);
  detector_.update(x);
  kind_->update(x);
}

void Collision::renew(const Points& x, double depth) {
  const Stopwatch watch(detection_time_);
  detector_.renew(x, depth);
}

bool Collision::add_candidates(Search& search, const Points& x, const ContactSurface& side, double least) {
  const Stopwatch watch(detection_time_);
  const std::size_t known = search.keys.size();
  for (const std::int32_t key : kind_->violated(x, search.reach, side, least)) {
    const auto at = std::lower_bound(search.keys.begin(), search.keys.end(), key);
    if (at == search.keys.end() || *at != key) search.keys.insert(at, key);
  }
  return search.keys.size() > known;
}

Complementarity Collision::closing_forces(Search& search, const std::vector<Constraint>& constraints,
                                          const Points& x) {
  constexpr int most_sweeps = 20000;  // of block Gauss-Seidel, with friction
  constexpr int few_pivots = 30;
  const Points& x_free = search.x_free;
  const Points& x_before = search.before.x;
  const std::vector<char> guess = first_guess(constraints, search.last, search.before.closed, x);
  std::vector<Row>& rows = search.last.rows;
  const auto solve = [&](int most_pivots) -> Complementarity {
    for (std::size_t i = 0; i < constraints.size(); ++i) method_->complete(rows[i], constraints[i], x_free);
    if (!friction_) return force_solver_->solve(rows, search.scale, guess, 0.1 * tolerance(), most_pivots);
    for (const Constraint& constraint : constraints) {
      const Vector3 t = constraint.normal.unitOrthogonal();
      rows.push_back(constraint.slip_row(t, x_before, x_free));
      rows.push_back(constraint.slip_row(constraint.normal.cross(t), x_before, x_free));
    }
    return solve_coulomb(force_solver_->compliance(rows, search.scale), free_gaps(rows), friction_->coefficient,
                         last_friction(constraints, search.last), 0.1 * tolerance(), most_sweeps);
  };

  rows.clear();
  for (const Constraint& constraint : constraints)
    rows.push_back(constraint.row(constraint.gradient, constraint.gap(x_free)));
  Complementarity solution = solve(few_pivots);
  if (solution.converged) return solution;

  rows.clear();
  for (const Constraint& constraint : constraints)
    rows.push_back(constraint.row(
        constraint.normal,
        constraint.gap(x) + constraint.normal.dot(constraint.offset(x_free) - constraint.offset(x))));
  const int pivots = solution.pivots;
  solution = solve(100 + 20 * static_cast<int>(constraints.size()));
  solution.pivots += pivots;
  return solution;
}

Vector Collision::pressure(const Contact& contact, const Points& x) {
  if (!friction_) return kind_->pressure(contact, x);
  const Vector pressing = without_shear(contact.nodal_force);
  return kind_->pressure({pressing, contact.closed, contact.force}, x);
}

std::vector<PressedNode> Collision::pressed(const ContactSurface& side, const Contact& contact, const Points& x) {
  if (!friction_) return kind_->pressed(side, contact, x);
  const Vector pressing = without_shear(contact.nodal_force);
  return kind_->pressed(side, {pressing, contact.closed, contact.force}, x);
}

Vector Collision::without_shear(const Vector& force) const {
  Vector pressing = Vector::Zero(force.size());
  for (const ContactSurface* side : {&detector_.first(), &detector_.second()})
    for (const std::int32_t node : side->nodes()) {
      const Vector3 n = side->normal(node);
      pressing.segment<3>(3 * node) = n * std::min(0.0, n.dot(force.segment<3>(3 * node)));
    }
  return pressing;
}

Contacts Collision::solve(const Points& x_free, double scale, const BeforeContact& before, Contacts known,
                          Points& x) {
  constexpr int few = 10;  // passes: a search that goes on needs one or two, or begins in the wrong place
  Search search{x_free, scale, before, reach(before, x_free, 0.0)};
  if (known.facing)
    return held_facing(search, known.passes, known.pivots, "Contact: facing nodes cannot be held apart.", x);
  // What a method makes of its constraints as it goes is not carried from one x_free to another.
  if (!known.constraints.empty() && !method_->renews_constraints()) {
    for (const Constraint& constraint : known.constraints) search.keys.push_back(constraint.key);
    search.last = known;
    x = x_free;
    force_solver_->move(known.rows, known.force, scale, x_free, x);
    search.shifted = force_solver_->shifted();
    try {
      Outcome found = search_on(search, std::min(few, options_.max_passes), x);
      if (found.contacts && found.contacts->converged && !passed_through(x)) return std::move(*found.contacts);
    } catch (const SolveFailed&) {  // of forces in the wrong place: from the start they are others
    }
    known.passes = search.last.passes;
    known.pivots = search.last.pivots;
  }
  search.keys = method_->begin(before);
  search.last = {};
  search.shifted = 0;
  search.last.passes = known.passes;
  search.last.pivots = known.pivots;
  x = x_free;
  const auto searched = [&]() -> Outcome {
    if (!facing_) return search_on(search, options_.max_passes, x);
    try {
      return search_on(search, options_.max_passes, x);
    } catch (const SolveFailed& failure) {
      return {{}, failure.what()};
    }
  };
  Outcome outcome = searched();
  if (outcome.contacts && !passed_through(x)) return std::move(*outcome.contacts);
  if (!facing_) throw SolveFailed(outcome.failure);
  return held_facing(search, search.last.passes, search.last.pivots, outcome.failure, x);
}

bool Collision::passed_through(const Points& x) const {
  // Others settle where nodes that face each other at rest have slid apart, rightly so.
  return facing_are_images_ && facing_->deepest(x) < -acceptable * tolerance();
}

Contacts Collision::held_facing(const Search& search, int passes, int pivots, const std::string& failure,
                                Points& x) {
  constexpr double close = 0.1;  // tolerances, to which forces are found
  const Points &x_free = search.x_free, &x_before = search.before.x;
  Contacts found;
  found.facing = true;
  found.passes = passes;
  found.pivots = pivots;
  std::vector<std::int32_t> keys = facing_->closer(x_free, x_before, 0.0);
  x = x_free;
  while (!keys.empty()) {
    const Contacts last = std::move(found);
    found = {};
    found.facing = true;
    std::vector<char> guess;
    for (const std::int32_t key : keys) {
      const Constraint& constraint = found.constraints.emplace_back(facing_->at(key, x_before));
      found.rows.push_back(constraint.row(constraint.normal, constraint.gap(x_free)));
      guess.push_back(constraint.gap(x) < 0 || last.force_of(key) > 0);
    }
    Complementarity solution = force_solver_->solve(found.rows, search.scale, std::move(guess),
                                                    close * tolerance(), 100 + 20 * static_cast<int>(keys.size()));
    found.passes = last.passes + 1;
    found.pivots = last.pivots + solution.pivots;
    if (!solution.converged) throw SolveFailed(failure);
    found.force = std::move(solution.force);
    force_solver_->move(found.rows, found.force, search.scale, x_free, x);
    std::vector<std::int32_t> all;
    const std::vector<std::int32_t> behind = facing_->closer(x, x_before, close * tolerance());
    std::set_union(keys.begin(), keys.end(), behind.begin(), behind.end(), std::back_inserter(all));
    if (all.size() == keys.size()) break;
    keys = std::move(all);
  }
  update(x);
  found.converged = method_->settled(found, found.constraints, x, tolerance());
  if (found.gap_error > acceptable * tolerance()) throw SolveFailed(failure);
  return found;
}

Collision::Outcome Collision::search_on(Search& search, int max_passes, Points& x) {
  constexpr int relax_from = 3;      // passes that converge as Newton's method does are done by then
  constexpr int swings_from = 6;     // passes without the gap error falling by half
  constexpr int patience = 40;       // passes, for the gap error to fall by half, and of mirror images in all
  constexpr double settling = 1000;  // tolerances: below this gap error mortar averages say what they leave inside
  const BeforeContact& before = search.before;
  Contacts& last = search.last;
  last.converged = true;
  int& passes = search.passes = 0;
  Points linearised;  // positions that the last pass's constraints are of
  BestPass best;
  const auto closest = [&] {
    auto& [contacts, x_closest] = *best.pass;
    contacts.passes = last.passes;
    contacts.pivots = last.pivots;
    contacts.converged = false;
    x = std::move(x_closest);
    update(x);
    return Outcome{std::move(contacts), ""};
  };
  for (;; ++passes, ++last.passes) {
    update(x);
    search.reach = std::max(search.reach, reach(before, x, search.shifted));  // forces move surfaces too
    if (add_candidates(search, x, detector_.slave_side(), 0.0)) best = {{}, passes};
    std::vector<Constraint> constraints = constraints_at(search, x);
    // What is inside at all is solved for once, however shallow: a resting contact must not sink by the tolerance.
    if (passes > 0 || constraints.empty()) {
      const bool done = method_->settled(last, constraints, x, tolerance());
      // Mortar averages leave nodes inside as a rule, so these are looked for before the averages have settled.
      const bool late = method_->exact() && (done || (!at_nodes_ && last.gap_error <= settling * tolerance()));
      const bool more = late && add_candidates(search, x, detector_.master_side(),
                                               tolerance() + (done ? 0.0 : 2 * last.gap_error));
      if (done && !more) return {std::move(last), ""};
      if (more) best = {{}, passes};
      if (more || method_->renews_constraints()) constraints = constraints_at(search, x);
      if (!more && !method_->renews_constraints()) best.take(passes, last, x);
    }
    const bool close = best.within(acceptable * tolerance());
    if (close && (passes == max_passes || passes - best.halved >= patience)) {
      // The other side's nodes are looked for once the first are settled: these never were.
      update(best.pass->x);
      if (passes < max_passes && method_->exact() &&
          add_candidates(search, best.pass->x, detector_.master_side(), acceptable * tolerance())) {
        x = best.pass->x;
        best = {{}, passes};
        continue;
      }
      return closest();
    }
    // Mirror images have a solution that needs no pass, and these cost more than it.
    if (passes == max_passes || (facing_are_images_ && passes >= patience))
      return {{}, stopped_without_settling(passes, *method_, constraints, last, x, tolerance())};

    // Passes that lead from one of two shapes to the other and back are linearised between the two.
    if (best.pass && passes - best.halved >= swings_from) {
      linearised = 0.5 * (linearised + x);
      update(linearised);
      constraints = constraints_at(search, linearised);
    } else {
      linearised = x;
    }

    // Over a sharp edge the mean normal turns with the slave, and its force may swing from pass to pass: halve
    // that.
    if (passes >= relax_from)
      for (Constraint& constraint : constraints)
        if (const std::ptrdiff_t i = last.place_of(constraint.key); i >= 0)
          constraint.turn_towards(last.constraints[static_cast<std::size_t>(i)].normal);

    Complementarity solution = closing_forces(search, constraints, linearised);
    last.pivots += solution.pivots;
    if (!solution.converged) {
      if (close) return closest();
      return {{},
              "Contact: no consistent set of closed constraints among " + std::to_string(constraints.size()) +
                  " after " + std::to_string(solution.pivots) + (friction_ ? " sweeps" : " active sets") +
                  ". Try a smaller step."};
    }
    last.constraints = std::move(constraints);
    last.force = std::move(solution.force);
    force_solver_->move(last.rows, last.force, search.scale, search.x_free, x);
    search.shifted = force_solver_->shifted();
  }
}

}  // namespace plica

#include "plica/contact/collision.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "plica/contact/friction.hpp"
#include "plica/contact/mortar.hpp"
#include "plica/contact/node_pairs.hpp"
#include "plica/core/error.hpp"
#include "plica/core/stopwatch.hpp"

namespace plica {

namespace {

std::string place(const Vector3& x) {
  return "(" + number(x[0]) + ", " + number(x[1]) + ", " + number(x[2]) + ") m";
}

/// How far a constraint is from complementarity at positions x, m.
double violation(const Constraint& constraint, double force, const Points& x, const NormalStress* stress) {
  double off = constraint.residual(force, x);
  if (constraint.gamma > 0) off += stress->at(constraint.slave, constraint.normal, x) / constraint.gamma;
  return force == 0.0 ? std::max(0.0, -off) : std::abs(off);
}

/// Adds the tissue's normal stress over gamma to the row's gap.
void add_stress(const NormalStress& stress, const Constraint& constraint, const Points& x_free, Row& row) {
  row.free += stress.at(constraint.slave, constraint.normal, x_free) / constraint.gamma;
  for (const auto& [node, slope] : stress.slopes(constraint.slave, constraint.normal))
    row.gap.push_back({node, slope / constraint.gamma});
}

void require_positive(const char* name, double value, const char* unit) {
  if (!(value > 0) || !std::isfinite(value)) throw InvalidInput("Contact", name, value, unit, "> 0 and finite");
}

void validate(const Enforcement& enforcement) {
  if (const auto* penalty = std::get_if<Penalty>(&enforcement))
    require_positive("stiffness", penalty->stiffness, "N/m");
  if (const auto* volume = std::get_if<VolumePenalty>(&enforcement))
    require_positive("kappa", volume->kappa, "N/m^3");
  if (const auto* nitsche = std::get_if<Nitsche>(&enforcement)) require_positive("factor", nitsche->factor, "");
  if (const auto* augmented = std::get_if<Augmented>(&enforcement)) {
    require_positive("stiffness", augmented->stiffness, "N/m");
    if (!(augmented->growth > 1) || !std::isfinite(augmented->growth))
      throw InvalidInput("Contact", "growth", augmented->growth, "", "> 1 and finite");
    if (!(augmented->reduction > 0 && augmented->reduction < 1))
      throw InvalidInput("Contact", "reduction", augmented->reduction, "", "in (0, 1)");
    if (augmented->max_augmentations < 1)
      throw InvalidInput("Contact", "max_augmentations", augmented->max_augmentations, "", ">= 1");
  }
}

void validate(const std::optional<Friction>& friction, const Enforcement& enforcement) {
  if (!friction) return;
  require_positive("friction", friction->coefficient, "");
  const auto* multipliers = std::get_if<Multipliers>(&enforcement);
  if (!(multipliers && (std::holds_alternative<Condensed>(multipliers->solver) ||
                        std::holds_alternative<Automatic>(multipliers->solver))) &&
      !std::holds_alternative<Augmented>(enforcement))
    throw InvalidInput(
        "Contact: friction; must come with multipliers and the condensed solver, or with augmented multipliers.");
}

std::unique_ptr<ConstraintKind> make_kind(Detector& detector, const Enforcement& enforcement,
                                          const FaceMethod& faces) {
  const auto* volume = std::get_if<VolumePenalty>(&enforcement);
  if (const auto* mortar = std::get_if<Mortar>(&faces)) {
    if (volume)
      throw InvalidInput(
          "Contact: faces = \"mortar\"; must come with multipliers, augmented multipliers or the penalty: "
          "the volume penalty has its own faces, those of the airway's tetrahedra.");
    if (std::holds_alternative<Nitsche>(enforcement))
      throw InvalidInput(
          "Contact: faces = \"mortar\"; must come with multipliers, augmented multipliers or the penalty: "
          "Nitsche's method takes the tissue's stress at nodes.");
    return mortar_weights(detector, mortar->first, mortar->second);
  }
  return volume ? volume_pairs(detector, volume->kappa) : node_pairs(detector);
}

}  // namespace

void Contacts::add_forces(Vector& nodal) const {
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].add_force(force[static_cast<std::ptrdiff_t>(i)], nodal);
}

void Collision::Options::validate() const {
  if (!(tolerance > 0)) throw InvalidInput("Contact", "tolerance", tolerance, "mean edges", "> 0");
  if (max_passes < 1) throw InvalidInput("Contact", "max_passes", max_passes, "", ">= 1");
}

Collision::Collision(Airway airway, const Points& reference, Enforcement enforcement,
                     std::optional<Friction> friction, Options options, std::unique_ptr<ContactPath> path,
                     const FaceMethod& faces)
    : detector_(std::move(airway), reference),
      enforcement_(enforcement),
      friction_(friction),
      options_(options),
      path_(std::move(path)) {
  options_.validate();
  validate(enforcement_);
  validate(friction_, enforcement_);
  kind_ = make_kind(detector_, enforcement_, faces);
}

std::vector<Constraint> Collision::constraints_at(const Points& x, const std::vector<std::int32_t>& keys,
                                                  double reach, const Uzawa& uzawa, const NormalStress* stress) {
  const Stopwatch watch(detection_time_);
  const auto* penalty = std::get_if<Penalty>(&enforcement_);
  const auto* nitsche = std::get_if<Nitsche>(&enforcement_);
  const bool augmented = std::holds_alternative<Augmented>(enforcement_);
  std::vector<Constraint> constraints;
  constraints.reserve(keys.size());
  for (const std::int32_t key : keys) {
    Constraint constraint = kind_->at(key, x, reach);
    if (constraint.key < 0) continue;
    if (penalty) constraint.stiffness = penalty->stiffness;
    if (nitsche) {
      const std::int32_t slave = constraint.slave;
      const ContactSurface& own = detector_.first().contains(slave) ? detector_.first() : detector_.second();
      constraint.gamma = nitsche->factor * stress->stiffness(slave, constraint.normal, detector_.mean_edge());
      constraint.stiffness = constraint.gamma * own.tributary_area(slave);
    }
    if (augmented) {
      constraint.stiffness = uzawa.stiffness;
      if (const auto known = uzawa.multiplier.find(key); known != uzawa.multiplier.end())
        constraint.multiplier = known->second;
    }
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

bool Collision::add_candidates(const Points& x, double reach, const ContactSurface& side, double least,
                               std::vector<std::int32_t>& keys) {
  const Stopwatch watch(detection_time_);
  const std::size_t known = keys.size();
  for (const std::int32_t key : kind_->violated(x, reach, side, least)) {
    const auto at = std::lower_bound(keys.begin(), keys.end(), key);
    if (at == keys.end() || *at != key) keys.insert(at, key);
  }
  return keys.size() > known;
}

Complementarity Collision::closing_forces(const std::vector<Constraint>& constraints, const Points& x,
                                          const Points& x_free, const Before& before, double scale,
                                          std::vector<char> guess, const Vector& start, Contacts& contacts) {
  const auto count = static_cast<std::ptrdiff_t>(constraints.size());
  std::vector<Row>& rows = contacts.rows;
  constexpr int most_sweeps = 20000;  // of block Gauss-Seidel, with friction
  const auto solve = [&](std::vector<char> first, int most) -> Complementarity {
    for (std::size_t i = 0; i < constraints.size(); ++i)
      if (constraints[i].gamma > 0) add_stress(*before.stress, constraints[i], x_free, rows[i]);
    if (!friction_) return path_->solve(rows, scale, std::move(first), 0.1 * tolerance(), most);
    for (const Constraint& constraint : constraints) {
      const Vector3 t = constraint.normal.unitOrthogonal();
      rows.push_back(constraint.slip_row(t, before.x, x_free));
      rows.push_back(constraint.slip_row(constraint.normal.cross(t), before.x, x_free));
    }
    Vector free(3 * count);
    for (std::ptrdiff_t i = 0; i < free.size(); ++i) free[i] = rows[static_cast<std::size_t>(i)].free;
    return solve_coulomb(path_->compliance(rows, scale), free, friction_->coefficient, start, 0.1 * tolerance(),
                         most_sweeps);
  };

  rows.clear();
  for (const Constraint& constraint : constraints)
    rows.push_back(constraint.row(constraint.gradient, constraint.gap(x_free)));
  constexpr int few_pivots = 30;
  Complementarity solution = solve(guess, few_pivots);
  if (solution.converged) return solution;

  rows.clear();
  for (const Constraint& constraint : constraints)
    rows.push_back(constraint.row(
        constraint.normal,
        constraint.gap(x) + constraint.normal.dot(constraint.offset(x_free) - constraint.offset(x))));
  const int pivots = solution.pivots, most_pivots = 100 + 20 * static_cast<int>(constraints.size());
  solution = solve(std::move(guess), most_pivots);
  solution.pivots += pivots;
  if (!solution.converged)
    throw SolveFailed("Contact: no consistent set of closed constraints among " +
                      std::to_string(constraints.size()) + " after " + std::to_string(solution.pivots) +
                      (friction_ ? " sweeps" : " active sets") + ". Try a smaller step.");
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

bool Collision::augment(const std::vector<Constraint>& constraints, const Points& x, Contacts& contacts,
                        Uzawa& uzawa) const {
  const auto& augmented = std::get<Augmented>(enforcement_);
  uzawa.multiplier.clear();
  for (std::size_t i = 0; i < contacts.constraints.size(); ++i)
    if (const double force = contacts.force[static_cast<std::ptrdiff_t>(i)]; force > 0)
      uzawa.multiplier[contacts.constraints[i].key] = force;
  double error = 0;
  for (const Constraint& constraint : constraints) {
    const double gap = constraint.gap(x);
    error = std::max(error, uzawa.multiplier.count(constraint.key) ? std::abs(gap) : -gap);
  }
  contacts.gap_error = error;
  contacts.converged = error <= tolerance();
  if (contacts.converged || contacts.augmentations >= augmented.max_augmentations) return false;
  if (error > (1 - augmented.reduction) * uzawa.last_error) uzawa.stiffness *= augmented.growth;
  uzawa.last_error = error;
  ++contacts.augmentations;
  return true;
}

Contacts Collision::solve(const Points& x_free, double scale, const Before& before, Points& x) {
  constexpr int relax_from = 3;    // passes that converge as Newton's method does are done by then
  constexpr int settle_from = 20;  // a slave beside the rim is held in one direction from then on
  double reach = detector_.reach(before.x, x_free, before.depth);
  const auto* augmented = std::get_if<Augmented>(&enforcement_);
  const bool exact = augmented || std::holds_alternative<Multipliers>(enforcement_);
  Contacts contacts;
  std::vector<std::int32_t> keys;  // candidates of this step
  Uzawa uzawa{0.0, {}};
  if (augmented) {
    uzawa.stiffness = augmented->stiffness;
    keys = before.closed;
    for (std::size_t i = 0; i < keys.size(); ++i)
      uzawa.multiplier[keys[i]] = before.force[static_cast<std::ptrdiff_t>(i)];
  }
  x = x_free;
  detector_.forget();
  for (contacts.passes = 0;; ++contacts.passes) {
    // Place of a key among the constraints of the pass before, or -1.
    const auto known = [&](std::int32_t key) -> std::ptrdiff_t {
      const auto at = std::lower_bound(contacts.constraints.begin(), contacts.constraints.end(), key,
                                       [](const Constraint& c, std::int32_t k) { return c.key < k; });
      return at != contacts.constraints.end() && at->key == key ? at - contacts.constraints.begin() : -1;
    };
    const auto force_of = [&](std::int32_t key) {
      const std::ptrdiff_t i = known(key);
      return i < 0 ? 0.0 : contacts.force[i];
    };
    update(x);
    reach = std::max(reach, detector_.reach(before.x, x, before.depth));  // contact forces move surfaces too
    add_candidates(x, reach, detector_.slave_side(), 0.0, keys);
    const auto constraints_now = [&] {
      std::vector<Constraint> all = constraints_at(x, keys, reach, uzawa, before.stress);
      if (contacts.passes < settle_from) return all;
      for (Constraint& constraint : all) {
        const std::ptrdiff_t i = known(constraint.key);
        if (i < 0 || !constraint.beside(x, tolerance())) continue;
        const Constraint& last = contacts.constraints[static_cast<std::size_t>(i)];
        constraint.weights = last.weights;
        constraint.normal = last.normal;
        constraint.gradient = last.gradient;
      }
      return all;
    };
    std::vector<Constraint> constraints = constraints_now();
    double worst = 0;
    const Constraint* worst_one = nullptr;
    const auto find_worst = [&] {
      worst = 0;
      worst_one = constraints.data();
      for (const Constraint& constraint : constraints)
        if (const double off = violation(constraint, force_of(constraint.key), x, before.stress); off > worst)
          worst = off, worst_one = &constraint;
    };
    find_worst();
    // What is inside at all is solved for once, however shallow: a resting contact must not sink by the tolerance.
    if (contacts.passes > 0 || constraints.empty()) {
      const bool again = augmented && augment(constraints, x, contacts, uzawa);
      const bool done = !again && (augmented || worst <= tolerance());
      if (!augmented) contacts.gap_error = worst;
      if (done && !(exact && add_candidates(x, reach, detector_.master_side(), tolerance(), keys)))
        return contacts;
      if (again || done) {
        constraints = constraints_now();
        find_worst();
      }
    }
    if (contacts.passes == options_.max_passes)
      throw SolveFailed("Contact: gap error " + number(worst) + " m after " + std::to_string(contacts.passes) +
                        " passes (tolerance " + number(tolerance()) + " m), worst at node " +
                        std::to_string(worst_one->slave) + " " + place(x.row(worst_one->slave)) +
                        ". Try a smaller step, or a larger tolerance.");

    // Over a sharp edge the mean normal turns with the slave, and its force may swing from pass to pass: halve
    // that.
    if (contacts.passes >= relax_from)
      for (Constraint& constraint : constraints)
        if (const std::ptrdiff_t i = known(constraint.key); i >= 0)
          constraint.turn_towards(contacts.constraints[static_cast<std::size_t>(i)].normal);

    std::vector<char> guess(constraints.size());
    for (std::size_t i = 0; i < constraints.size(); ++i)
      guess[i] = contacts.passes == 0
                     ? std::binary_search(before.closed.begin(), before.closed.end(), constraints[i].key) ||
                           constraints[i].gap(x) < 0
                     : force_of(constraints[i].key) > 0 || constraints[i].gap(x) < 0;
    Vector start;
    if (friction_) {  // where the pass before ended
      const auto count = static_cast<std::ptrdiff_t>(constraints.size());
      const auto old = static_cast<std::ptrdiff_t>(contacts.constraints.size());
      start = Vector::Zero(3 * count);
      for (std::ptrdiff_t i = 0; i < count; ++i)
        if (const std::ptrdiff_t k = known(constraints[static_cast<std::size_t>(i)].key); k >= 0) {
          start[i] = contacts.force[k];
          start.segment<2>(count + 2 * i) = contacts.force.segment<2>(old + 2 * k);
        }
    }
    Complementarity solution =
        closing_forces(constraints, x, x_free, before, scale, std::move(guess), start, contacts);
    contacts.pivots += solution.pivots;
    contacts.constraints = std::move(constraints);
    contacts.force = std::move(solution.force);
    path_->move(contacts.rows, contacts.force, scale, x_free, x);
  }
}

}  // namespace plica

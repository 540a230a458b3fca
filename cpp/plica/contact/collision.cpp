#include "plica/contact/collision.hpp"

#include <algorithm>

#include "plica/core/error.hpp"
#include "plica/core/stopwatch.hpp"

namespace plica {

namespace {

std::string place(const Vector3& x) {
  return "(" + number(x[0]) + ", " + number(x[1]) + ", " + number(x[2]) + ") m";
}

/// How far a pair is from complementarity at positions x, m.
double violation(const Pair& pair, double force, const Points& x) {
  const double gap = pair.gap(x);
  if (force == 0.0) return std::max(0.0, -gap);
  return std::abs(pair.stiffness > 0 ? gap + force / pair.stiffness : gap);
}

}  // namespace

void Collision::Options::validate() const {
  if (!(tolerance > 0)) throw InvalidInput("Contact", "tolerance", tolerance, "mean edges", "> 0");
  if (max_passes < 1) throw InvalidInput("Contact", "max_passes", max_passes, "", ">= 1");
}

Collision::Collision(Airway airway, const Points& reference, Enforcement enforcement, Options options,
                     std::unique_ptr<ContactPath> path)
    : detector_(std::move(airway), reference),
      enforcement_(enforcement),
      options_(options),
      path_(std::move(path)) {
  options_.validate();
  if (const auto* penalty = std::get_if<Penalty>(&enforcement_); penalty && !(penalty->stiffness > 0))
    throw InvalidInput("Contact", "stiffness", penalty->stiffness, "N/m", "> 0");
  if (const auto* volume = std::get_if<VolumePenalty>(&enforcement_); volume && !(volume->kappa > 0))
    throw InvalidInput("Contact", "kappa", volume->kappa, "N/m^3", "> 0");
}

std::vector<Pair> Collision::pairs_at(const Points& x, const std::vector<std::int32_t>& keys) {
  const Stopwatch watch(detection_time_);
  std::vector<Pair> pairs;
  pairs.reserve(keys.size());
  if (const auto* volume = std::get_if<VolumePenalty>(&enforcement_)) {
    for (const std::int32_t tet : keys)
      if (const Pair pair = detector_.volume_pair(tet, x, volume->kappa); pair.key >= 0) pairs.push_back(pair);
    return pairs;
  }
  const auto* penalty = std::get_if<Penalty>(&enforcement_);
  for (const std::int32_t slave : keys) {
    pairs.push_back(detector_.pair(slave, x));
    if (penalty) pairs.back().stiffness = penalty->stiffness;
  }
  return pairs;
}

void Collision::update_detector(const Points& x) {
  const Stopwatch watch(detection_time_);
  detector_.update(x);
}

void Collision::renew(const Points& x, double depth) {
  const Stopwatch watch(detection_time_);
  detector_.renew(x, depth);
}

bool Collision::add_candidates(const Points& x, double reach, const ContactSurface& side, double least,
                               std::vector<std::int32_t>& keys) {
  const Stopwatch watch(detection_time_);
  const std::size_t known = keys.size();
  const auto add = [&](std::int32_t key) {
    const auto at = std::lower_bound(keys.begin(), keys.end(), key);
    if (at == keys.end() || *at != key) keys.insert(at, key);
  };
  if (std::holds_alternative<VolumePenalty>(enforcement_)) {
    for (const std::int32_t tet : detector_.inverted_tets()) {
      const Pair by_volume = detector_.volume_pair(tet, x, 1.0);
      if (by_volume.key >= 0 && detector_.pair(by_volume.slave, x).penetrates(x, reach)) add(tet);
    }
  } else {
    for (const Pair& pair : detector_.inside(side, x, reach))
      if (pair.gap(x) < -least) add(pair.slave);
  }
  return keys.size() > known;
}

Complementarity Collision::closing_forces(const std::vector<Pair>& pairs, const Points& x, const Points& x_free,
                                          double scale, std::vector<char> guess) {
  const auto count = static_cast<std::ptrdiff_t>(pairs.size());
  LinearGaps gaps{std::vector<Vector3>(pairs.size()), Vector(count)};
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const Pair& pair = pairs[static_cast<std::size_t>(i)];
    gaps.direction[static_cast<std::size_t>(i)] = pair.gradient;
    gaps.free[i] = pair.gradient.dot(pair.offset(x_free));
  }
  constexpr int few_pivots = 30;
  Complementarity solution = path_->solve(pairs, gaps, scale, guess, 0.1 * tolerance(), few_pivots);
  if (solution.converged) return solution;

  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const Pair& pair = pairs[static_cast<std::size_t>(i)];
    gaps.direction[static_cast<std::size_t>(i)] = pair.normal;
    gaps.free[i] = pair.gap(x) + pair.normal.dot(pair.offset(x_free) - pair.offset(x));
  }
  const int pivots = solution.pivots, most_pivots = 100 + 20 * static_cast<int>(count);
  solution = path_->solve(pairs, gaps, scale, std::move(guess), 0.1 * tolerance(), most_pivots);
  solution.pivots += pivots;
  if (!solution.converged)
    throw SolveFailed("Contact: no consistent set of closed pairs among " + std::to_string(count) + " after " +
                      std::to_string(solution.pivots) + " active sets. Try a smaller step.");
  return solution;
}

Contacts Collision::solve(const Points& x_free, double scale, const Before& before, Points& x) {
  constexpr int relax_from = 3;  // passes that converge as Newton's method does are done by then
  const double reach = detector_.reach(before.x, x_free, before.depth);
  const bool exact = std::holds_alternative<Multipliers>(enforcement_);
  Contacts contacts;
  std::vector<std::int32_t> keys;  // candidates of this step
  x = x_free;
  detector_.forget();
  for (contacts.passes = 0;; ++contacts.passes) {
    // Place of a key among the pairs of the pass before, or -1.
    const auto known = [&](std::int32_t key) -> std::ptrdiff_t {
      const auto at = std::lower_bound(contacts.pairs.begin(), contacts.pairs.end(), key,
                                       [](const Pair& pair, std::int32_t k) { return pair.key < k; });
      return at != contacts.pairs.end() && at->key == key ? at - contacts.pairs.begin() : -1;
    };
    const auto force_of = [&](std::int32_t key) {
      const std::ptrdiff_t i = known(key);
      return i < 0 ? 0.0 : contacts.force[i];
    };
    update_detector(x);
    add_candidates(x, reach, detector_.slave_side(), 0.0, keys);
    std::vector<Pair> pairs = pairs_at(x, keys);
    double worst = 0;
    const Pair* worst_pair = nullptr;
    for (const Pair& pair : pairs) {
      const double off = violation(pair, force_of(pair.key), x);
      if (off > worst) worst = off, worst_pair = &pair;
    }
    // What is inside at all is solved for once, however shallow: a resting contact must not sink by the tolerance.
    if (worst <= tolerance() && (contacts.passes > 0 || pairs.empty())) {
      if (!exact || !add_candidates(x, reach, detector_.master_side(), tolerance(), keys)) return contacts;
      pairs = pairs_at(x, keys);
      worst = 0;
      for (const Pair& pair : pairs)
        if (-pair.gap(x) > worst) worst = -pair.gap(x), worst_pair = &pair;
    }
    if (contacts.passes == options_.max_passes)
      throw SolveFailed("Contact: gap error " + number(worst) + " m after " + std::to_string(contacts.passes) +
                        " passes (tolerance " + number(tolerance()) + " m), worst at node " +
                        std::to_string(worst_pair->slave) + " " + place(x.row(worst_pair->slave)) +
                        ". Try a smaller step, or a larger tolerance.");

    // Over a sharp edge the mean normal turns with the slave, and its force may swing from pass to pass: halve
    // that.
    if (contacts.passes >= relax_from)
      for (Pair& pair : pairs)
        if (const std::ptrdiff_t i = known(pair.key); i >= 0)
          pair.normal = (pair.normal + contacts.pairs[static_cast<std::size_t>(i)].normal).normalized();

    std::vector<char> guess(pairs.size());
    for (std::size_t i = 0; i < pairs.size(); ++i)
      guess[i] =
          contacts.passes == 0
              ? std::binary_search(before.closed.begin(), before.closed.end(), pairs[i].key) || pairs[i].gap(x) < 0
              : force_of(pairs[i].key) > 0 || pairs[i].gap(x) < 0;
    Complementarity solution = closing_forces(pairs, x, x_free, scale, std::move(guess));
    contacts.pivots += solution.pivots;
    contacts.pairs = std::move(pairs);
    contacts.force = std::move(solution.force);
    path_->move(contacts.pairs, contacts.force, scale, x_free, x);
  }
}

}  // namespace plica

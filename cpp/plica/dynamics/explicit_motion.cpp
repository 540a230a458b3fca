#include "plica/dynamics/explicit_motion.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "plica/core/error.hpp"
#include "plica/core/stopwatch.hpp"
#include "plica/core/threads.hpp"
#include "plica/dynamics/scene_contact.hpp"
#include "plica/dynamics/scene_flow.hpp"

namespace plica {

namespace {

[[noreturn]] void refuse(const std::string& what, const std::string& instead) {
  throw InvalidInput("Simulation: central differences with " + what + "; must be " + instead + ".");
}

[[noreturn]] void refuse_step(double h, double largest, const std::string& where) {
  throw InvalidInput(
      "Simulation", "step", h, "s", "<= " + number_text(largest) + " s",
      "Central differences are not stable with longer ones" + where + "; hht and newmark are with any.");
}

void require_explicit(const Scene& scene, const Motion::Options& options) {
  if (options.mass != CellMass::lumped) refuse("a consistent mass", "a lumped one: nothing is solved for");
  if (scene.reduction) refuse("a reduction", "another scheme, whose steps of few coordinates are not limited");
  if (!scene.contact) return;
  const ContactPart& part = *scene.contact;
  if (!std::holds_alternative<Penalty>(part.enforcement) &&
      !std::holds_alternative<VolumePenalty>(part.enforcement))
    refuse("contact that is solved for", "a penalty: its forces follow from positions alone");
  if (part.friction) refuse("friction", "left out, or another scheme: it is solved for");
  if (part.surface_mass == SurfaceMass::redistributed)
    refuse("massless contact nodes", "nodes that have mass, surface_mass = \"kept\"");
}

/// (3 n) of the lumped mass, whose matrix is diagonal.
Vector diagonal(const NodalMatrix& mass) {
  Vector masses(mass.rows());
  for (std::int32_t i = 0; i < mass.pattern()->rows(); ++i)
    masses.segment<3>(3 * static_cast<std::ptrdiff_t>(i))
        .setConstant(mass.values()[static_cast<std::size_t>(mass.pattern()->find(i, i))]);
  return masses;
}

Vector inverse(const Vector& mass, const Supports& supports) {
  Vector inverse = mass.cwiseInverse();
  supports.project(inverse);
  return inverse;
}

/// 1/kg of each node of all, zero where it is held; of one of a symmetric scene as it moves alone, which bounds
/// what its images do together.
struct NodeLightness {
  const Vector& inverse_mass;  // (3 n) of the unknowns
  const MirrorImages* images;
  double operator()(std::int32_t node) const {
    const std::int32_t own = images ? images->node_of(node) : node;
    const double alone = inverse_mass.segment<3>(3 * static_cast<std::ptrdiff_t>(own)).maxCoeff();
    return images ? images->count(own) * alone : alone;
  }
};

/// 1/s^2, a bound of the largest eigenvalue of M^-1 K_c where all nodes of the surfaces are in contact: see
/// contact_stiffness, each node facing one.
double stiffness_of_all(const Scene& scene, const NodeLightness& lightness) {
  const Penalty* penalty = scene.contact ? std::get_if<Penalty>(&scene.contact->enforcement) : nullptr;
  if (!penalty) return 0.0;
  double lightest = 0.0;
  int free_sides = 0;
  for (const Triangles* side : {&scene.contact->airway.first, &scene.contact->airway.second}) {
    double of_side = 0.0;
    for (const std::int32_t node : side->reshaped()) of_side = std::max(of_side, lightness(node));
    free_sides += of_side > 0;
    lightest = std::max(lightest, of_side);
  }
  return free_sides * penalty->stiffness * lightest;
}

/// The same of the closed rows: K_c = sum of p g^T / compliance, p and g a row's push and gap, along each other.
/// By Cauchy and Schwarz it is below the diagonal D_i = sum |p| |g_i| / compliance, |p| summed over free nodes.
struct Stiffest {
  double value = 0.0;  // 1/s^2
  std::int32_t node = -1;
};
Stiffest contact_stiffness(const Contacts& contacts, const NodeLightness& lightness) {
  std::vector<std::pair<std::int32_t, double>> shares;
  for (std::size_t j = 0; j < contacts.rows.size(); ++j) {
    const Row& row = contacts.rows[j];
    if (!(contacts.force[static_cast<std::ptrdiff_t>(j)] > 0)) continue;
    double pushed = 0.0;
    for (const auto& [node, vector] : row.push)
      if (lightness(node) > 0) pushed += vector.norm();
    for (const auto& [node, vector] : row.gap)
      shares.emplace_back(node, pushed * vector.norm() / row.compliance * lightness(node));
  }
  std::sort(shares.begin(), shares.end());
  Stiffest stiffest;
  double sum = 0.0;
  for (std::size_t k = 0; k < shares.size(); ++k) {
    sum = (k > 0 && shares[k].first == shares[k - 1].first ? sum : 0.0) + shares[k].second;
    if (sum > stiffest.value) stiffest = {sum, shares[k].first};
  }
  return stiffest;
}

}  // namespace

ExplicitMotion::ExplicitMotion(const Scene& scene, const Motion& motion)
    : motion_(motion),
      mass_((require_explicit(scene, motion.options()), diagonal(motion.mass()))),
      inverse_mass_(inverse(mass_, motion.supports())),
      stable_(inverse_mass_, StableStep::slopes_of(motion.stiffness(), motion.viscosity())),
      contact_stiffness_(stiffness_of_all(scene, {inverse_mass_, motion.images()})),
      eigenvalue_(stable_.eigenvalue(motion.step())) {
  const double h = motion.step();
  if (eigenvalue_ + 0.25 * h * h * contact_stiffness_ > 1) refuse_step(h, largest_step(), "");
  if (motion.excess()) watch_.emplace(motion, inverse_mass_);
}

void ExplicitMotion::require_stable(const State& now, const Contacts& contacts) {
  const auto [value, node] = contact_stiffness(contacts, {inverse_mass_, motion_.images()});
  const double h = motion_.step();
  const auto fail = [&](const std::string& what, double largest, const std::string& remedy) {
    throw SolveFailed(what + " asks for steps of at most " + number_text(largest) + " s; the step is " +
                      number_text(h) + " s. Shorten the step, or " + remedy);
  };
  const auto of_contact = [&](double largest) {
    fail("Contact: its stiffness at node " + std::to_string(node), largest, "lower the stiffness of the penalty.");
  };
  if (!watch_) {
    if (eigenvalue_ + 0.25 * h * h * value > 1) of_contact(stable_.largest(value));
    return;
  }
  const auto too_long = watch_->at(now.displacement, now.step, value);
  if (!too_long) return;
  if (too_long->with_tissue_alone)
    fail("tissue at finite strain: its stiffness as it is deformed now, most in " +
             motion_.excess()->cell_text(too_long->stiffest) + ",",
         too_long->largest, "take hht or newmark, which are stable with any.");
  of_contact(too_long->largest);
}

Vector ExplicitMotion::momentum(const Vector& velocity) const { return mass_.cwiseProduct(velocity); }

Ledger ExplicitMotion::opened_ledger(const State& state) const {
  return plica::opened_ledger(state, momentum(state.velocity), motion_.excess());
}

Ledger ExplicitMotion::continued_ledger(const State& before, const State& now) const {
  const Vector still = Vector::Zero(before.step == 0 ? mass_.size() : 0);  // no step of theirs is shifted
  return plica::continued_ledger({motion_.scheme(), motion_.step(), motion_.viscosity().has_value(), still,
                                  motion_.massless(), motion_.excess()},
                                 before, now, momentum(now.velocity));
}

void ExplicitMotion::accelerate(const State& last, const Vector& velocity, State& now) const {
  if (const ExcessForce* law = motion_.excess()) {
    ExcessForce::Force excess;
    if (const auto cell = law->at(now.displacement, velocity, excess)) law->fail_inside_out(*cell, "");
    now.elastic_excess = std::move(excess.elastic);
    now.viscous_excess = std::move(excess.viscous);
  }
  const bool nonlinear = now.elastic_excess.size() > 0, dashed = now.viscous_excess.size() > 0;
  const double h = motion_.step();
  const bool first = last.acceleration.size() == 0, touching = now.contact_force.size() > 0;
  const BlockMatrix& K = motion_.stiffness();
  const auto& C = motion_.viscosity();
  for (Vector* v : {&now.acceleration, &now.elastic_force, &now.inertial_force}) v->resize(mass_.size());
  if (C) now.viscous_force.resize(mass_.size());
  if (!first) now.velocity.resize(mass_.size());
  for_chunks(
      K.pattern()->rows(), BlockMatrix::chunk_rows, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
        const auto part = [at = 3 * begin, count = 3 * (end - begin)](auto& v) { return v.segment(at, count); };
        K.multiply_rows(begin, end, now.displacement, now.elastic_force);
        part(now.acceleration) = part(now.load) - part(now.elastic_force);
        if (C) {
          C->multiply_rows(begin, end, velocity, now.viscous_force);
          part(now.acceleration) -= part(now.viscous_force);
        }
        if (nonlinear) part(now.acceleration) -= part(now.elastic_excess);
        if (dashed) part(now.acceleration) -= part(now.viscous_excess);
        if (touching) part(now.acceleration) += part(now.contact_force);
        part(now.acceleration).array() *= part(inverse_mass_).array();
        part(now.inertial_force) = part(mass_).cwiseProduct(part(now.acceleration));
        if (!first)
          part(now.velocity) = part(last.velocity) + 0.5 * h * (part(last.acceleration) + part(now.acceleration));
      });
  now.weighted_elastic_force = now.elastic_force;
}

void ExplicitMotion::begin(State& state) {
  if (motion_.excess()) {
    motion_.excess()->at_start(state.displacement, state.velocity);
    if (const auto too_long = watch_->at(state.displacement, state.step, 0.0))
      refuse_step(motion_.step(), too_long->largest, " where the tissue is at t = 0");
  }
  accelerate(State{}, state.velocity, state);
}

/// Where it leads is known from the beginning.
class ExplicitStep final : public NodalStep {
 public:
  ExplicitStep(ExplicitMotion& motion, const State& last, Vector scene_load, const SceneFlow* flow,
               SceneContact* contact, StepTimes& times);

  Vector areas(Instant at) const override { return flow_->areas(positions(at)); }
  AirwayExpansion expansion(Instant at) const override {
    return flow_->expansion([&](std::int32_t node) -> Vector3 {
      return explicit_.motion_.at(node, at == Instant::last ? last_.velocity : velocity_);
    });
  }
  void move() override { now_.load = scene_load_; }
  void move(const AirwayPressure& pressure, Instant at) override;
  bool blocks() const override {
    return contact_ && contact_->blocks(*flow_, contacts_, x_, x_previous_, last_.depth);
  }
  StepTimes& times() const override { return times_; }
  void complete() override;
  State end() override { return std::move(now_); }
  Vector take_image() override { return {}; }
  const Contacts& contacts() const override { return contacts_; }
  const Points& x_previous() const override { return x_previous_; }
  int iterations() const override { return 0; }
  int evaluations() const override { return explicit_.motion_.excess() ? 1 : 0; }

 private:
  void take_contacts();  // at x_
  const Points& positions(Instant at) const { return at == Instant::last ? x_previous_ : x_; }

  const ExplicitMotion& explicit_;
  const State& last_;
  const Vector scene_load_;
  const SceneFlow* flow_;
  SceneContact* contact_;
  StepTimes& times_;
  State now_;
  Vector velocity_;        // v^, of which the viscous forces are
  Points x_previous_, x_;  // (n, 3) m, where flow or contact see them
  Contacts contacts_;
};

ExplicitStep::ExplicitStep(ExplicitMotion& motion, const State& last, Vector scene_load, const SceneFlow* flow,
                           SceneContact* contact, StepTimes& times)
    : explicit_(motion),
      last_(last),
      scene_load_(std::move(scene_load)),
      flow_(flow),
      contact_(contact),
      times_(times),
      velocity_(last.displacement.size()) {
  const Motion& nodes = explicit_.motion_;
  const double h = nodes.step();
  now_.step = last.step + 1;
  {
    const Stopwatch watch(times_.residual);
    now_.displacement.resize(last.displacement.size());
    for_slices(last.displacement.size(), [&](std::ptrdiff_t at, std::ptrdiff_t count) {
      const auto part = [&](auto& v) { return v.segment(at, count); };
      part(now_.displacement) =
          part(last.displacement) + h * part(last.velocity) + 0.5 * h * h * part(last.acceleration);
      part(velocity_) = part(last.velocity) + h * part(last.acceleration);
    });
  }
  if (flow_ || contact_) {
    x_previous_ = nodes.positions(last.displacement);
    x_ = nodes.positions(now_.displacement);
  }
  take_contacts();
  const Stopwatch watch(nodes.excess() ? times_.tissue : times_.contact);
  motion.require_stable(now_, contacts_);
}

void ExplicitStep::take_contacts() {
  if (contact_ == nullptr) return;
  const Motion& nodes = explicit_.motion_;
  const Stopwatch watch(times_.contact);
  contact_->begin(x_previous_, last_.depth);
  contacts_ = contact_->forces_at(x_, x_previous_, last_);
  now_.contact_force = Vector::Zero(x_.size());
  if (contacts_.any_force()) contacts_.add_forces(now_.contact_force);
  now_.contact_force = nodes.folded(std::move(now_.contact_force));
  std::tie(now_.closed, now_.closed_force) = contacts_.closed();
}

void ExplicitStep::move(const AirwayPressure& pressure, Instant at) {
  const Stopwatch watch(times_.load);
  now_.load = scene_load_;
  flow_->add_load(positions(at), pressure, now_.load);
}

void ExplicitStep::complete() {
  const Stopwatch watch(times_.solve);
  explicit_.accelerate(last_, velocity_, now_);
  now_.ledger = last_.ledger;
  now_.first_signs = last_.first_signs;
}

std::unique_ptr<NodalStep> ExplicitMotion::step(const State& last, Vector scene_load, const SceneFlow* flow,
                                                SceneContact* contact, StepTimes& times) {
  return std::make_unique<ExplicitStep>(*this, last, std::move(scene_load), flow, contact, times);
}

}  // namespace plica

#include "plica/dynamics/simulation.hpp"

#include <cmath>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/core/stopwatch.hpp"
#include "plica/dynamics/initial_state.hpp"
#include "plica/dynamics/step.hpp"

namespace plica {

namespace {

Scene checked(Scene scene) {
  scene.validate();
  scene.mesh = labelled(std::move(scene.mesh));
  return scene;
}

std::optional<SymmetricPart> part_of(const Scene& scene) {
  return scene.symmetry ? std::optional<SymmetricPart>(scene) : std::nullopt;
}

Simulation::Options checked(Simulation::Options options) {
  options.validate();
  return options;
}

}  // namespace

Simulation::Simulation(Scene scene, Options options)
    : scene_(checked(std::move(scene))),
      part_(part_of(scene_)),
      assembler_(part_ ? part_->mesh : scene_.mesh),
      tissue_(scene_.mesh, part_ ? &*part_ : nullptr, scene_.strain ? StrainMeasure::green : StrainMeasure::small),
      motion_(scene_, part_ ? &*part_ : nullptr, assembler_, checked(options)),
      loads_(scene_, part_ ? &*part_ : nullptr, assembler_) {
  if (motion_.is_explicit()) explicit_.emplace(scene_, motion_);
  if (scene_.airflow) {
    flow_.emplace(scene_, motion_);
    air_.emplace(flow_->airflow(), motion_.step(), scene_.airflow->tubes);
    coupling_ = scene_.airflow->coupling;
    // Explicit steps have nothing to iterate.
    if (explicit_ && load_instant(coupling_) == AirColumn::Instant::weighted) coupling_ = Extrapolated{};
  }
  if (scene_.contact) contact_.emplace(scene_, motion_);
  if (contact_)
    seen_ = contact_->nodes();
  else if (flow_)
    seen_ = flow_->airflow().nodes();
  if (scene_.reduction)
    reduced_.emplace(scene_, motion_, air_ ? &*air_ : nullptr);
  else if (flow_ && !explicit_)
    flow_->find_response(scene_.airflow->coupling, motion_, seen_, air_->has_tubes());
  begin();
}

void Simulation::begin() {
  state_ =
      initial_state(scene_, motion_, loads_, air_ ? &*air_ : nullptr, reduced_ ? &reduced_->motion() : nullptr);
  const Points x = scene_.mesh.points + as_points(motion_.everywhere(state_.displacement));
  if (contact_) contact_->require_apart(motion_.positions(state_.displacement));
  if (reduced_) {
    state_ = reduced_->begun(state_);
    loads_.reduce(reduced_->motion().shapes());
  } else if (explicit_) {
    explicit_->begin(state_);
    state_.ledger = explicit_->opened_ledger(state_);
  } else {
    motion_.begin(state_);
    state_.ledger = opened_ledger(motion_, state_);
  }
  StepRecord start;
  start.inverted_tissue = static_cast<int>(tissue_.folded(x));
  state_.first_signs.note(0, start, x, scene_.mesh.cells);
}

StepTimes Simulation::times() const {
  StepTimes times = times_;
  if (contact_) {
    times.detection = contact_->collision().detection_time() - detection_of_records_;
    times.contact -= times.detection;
  }
  return times;
}

Points Simulation::positions() const { return scene_.mesh.points + as_points(displacement()); }

Vector Simulation::contact_force() const {
  if (!contact_) return {};
  if (reduced_) return reduced_->contact()->force(state_.interface_force);
  return motion_.shared(state_.contact_force);
}

Points Simulation::displacement_of(const Indices& nodes) const {
  require_indices("Simulation", "node", nodes, scene_.mesh.node_count());
  if (reduced_) return as_points(Vector(reduced_->motion().shapes_at(nodes) * state_.displacement));
  Points u(nodes.size(), 3);
  for (std::ptrdiff_t p = 0; p < u.rows(); ++p) u.row(p) = motion_.at(nodes[p], state_.displacement);
  return u;
}

Points Simulation::coronal(Side side) const {
  if (!flow_) throw InvalidInput("Simulation: coronal sections; must be of a scene with an airflow.");
  const Sections& sections = flow_->airflow().sections();
  if (reduced_) return reduced_->flow()->coronal(side, state_.displacement);
  Points at(sections.count(), 3);
  for (std::ptrdiff_t s = 0; s < at.rows(); ++s) {
    const MaterialPoint& point =
        (side == Side::right ? sections.right : sections.left)[static_cast<std::size_t>(s)];
    at.row(s).setZero();
    for (std::size_t k = 0; k < point.nodes.size(); ++k)
      at.row(s) += point.weights[k] * (scene_.mesh.points.row(point.nodes[k]) +
                                       motion_.at(point.nodes[k], state_.displacement).transpose());
  }
  return at;
}

Vector Simulation::contact_pressure() const {
  if (reduced_ && reduced_->contact()) return reduced_->contact()->pressure();
  if (contact_ && contact_->pressure().size() > 0) return contact_->pressure();
  return Vector::Zero(scene_.mesh.node_count());
}

void Simulation::set_external_force(Vector force) {
  if (force.size() != scene_.mesh.points.size())
    throw InvalidInput("Simulation", "external force", static_cast<double>(force.size()), "entries",
                       "3 times the " + std::to_string(scene_.mesh.node_count()) + " nodes");
  for (std::ptrdiff_t i = 0; i < force.size(); ++i)
    if (!std::isfinite(force[i]))
      throw InvalidInput("Simulation",
                         std::string("external force along ") + "xyz"[i % 3] + " on node " + std::to_string(i / 3),
                         force[i], "N", "finite");
  if (part_) force = part_->images.folded_symmetric(force, "the external force (N)", scene_.mesh.points);
  loads_.set_external(reduced_ ? reduced_->motion().forces(force) : std::move(force));
}

State::Shape Simulation::shape_of_states() const {
  std::function<bool(std::int32_t)> knows;
  if (contact_)
    knows = [&](std::int32_t key) { return reduced_ ? reduced_->contact()->knows(key) : collision()->knows(key); };
  return {reduced_ ? reduced_->motion().size() : stiffness().rows(),
          scene_.mesh.cell_count(),
          static_cast<std::ptrdiff_t>(scene_.mesh.layer_names.size()),
          reduced_ ? reduced_->motion().has_viscosity() : viscosity().has_value(),
          flow_.has_value(),
          knows,
          reduced_ ? reduced_->interface() : -1,
          !explicit_,
          scene_.strain.has_value()};
}

StateProducts Simulation::products_of_states() const {
  return reduced_ ? StateProducts(reduced_->motion()) : StateProducts(motion_);
}

State Simulation::renewed(State state) const {
  state.validate(shape_of_states());
  if (scene_.strain)
    throw InvalidInput(
        "Simulation: renewed with strain = finite; must be a scene of linear tissue. Begin another simulation "
        "with "
        "the changed motion as the scene's displacement and velocity.");
  State found = products_of_states().renewed(state);
  const double moved = (found.elastic_force - state.elastic_force).cwiseAbs().maxCoeff();
  if (contact_ && moved > 1e-8 * found.elastic_force.cwiseAbs().maxCoeff())
    throw InvalidInput(
        "Simulation: the displacement of a state with contact has changed; must be as it was. Begin another "
        "simulation with it, as the scene's displacement: what is in contact is sought from there.");
  return found;
}

void Simulation::restore(State state) {
  state.validate(shape_of_states());
  if (air_) air_->require(state.air);
  products_of_states().require(state);
  state_ = std::move(state);
  record_ = StepRecord{};
  record_.time = time();
  if (reduced_)
    reduced_->restore(state_);
  else if (contact_)
    contact_->update_pressure(state_, motion_.positions(state_.displacement));
}

void Simulation::advance() {
  const auto failed = [&](const std::exception& failure) {
    const std::int64_t next = state_.step + 1;
    const Vector3& origin = motion_.origin();
    const std::string seen_from = origin.isZero(0)
                                      ? ""
                                      : " (Its places are seen from (" + number_text(origin[0]) + ", " +
                                            number_text(origin[1]) + ", " + number_text(origin[2]) + ") m.)";
    return SolveFailed("Step " + std::to_string(next) +
                       " (t = " + number_text(static_cast<double>(next) * motion_.step()) +
                       " s): " + failure.what() + seen_from +
                       state_.first_signs.text(motion_.step(), tissue_.folded(positions()),
                                               scene_.mesh.cell_count(), !scene_.strain.has_value()));
  };
  try {
    if (reduced_) return advance_reduced();
    const double ahead = (1 + motion_.scheme().alpha) * motion_.step();
    const Vector scene_load = loads_.at(time() + ahead);
    const std::unique_ptr<NodalStep> step = begun_step(scene_load);
    std::optional<FlowRecord> flow;
    if (air_) {
      air_->begin_step(state_.air, time(), ahead, load_instant(coupling_));
      // Contact at the end of an explicit step is known from its beginning.
      if (explicit_ && load_instant(coupling_) == AirColumn::Instant::weighted) air_->stop(step->blocks());
    }
    const auto move = [&] { air_ ? couple(coupling_, *air_, *step, flow) : step->move(); };
    for (bool settled = false; !settled;) {
      try {
        move();
      } catch (const SolveFailed&) {
        if (!step->retreat()) throw;
        continue;
      }
      settled = step->settle();
    }
    step->complete();
    State now = step->end();
    if (air_) now.air = air_->end_step(flow->state);
    keep(std::move(now), flow, scene_load, *step);
  } catch (const SolveFailed& failure) {
    throw failed(failure);
  } catch (const InvalidInput& failure) {  // what was handed in is checked: positions that a step made diverge
    throw failed(failure);
  }
}

std::unique_ptr<NodalStep> Simulation::begun_step(const Vector& scene_load) {
  const SceneFlow* flow = flow_ ? &*flow_ : nullptr;
  SceneContact* contact = contact_ ? &*contact_ : nullptr;
  if (explicit_) return explicit_->step(state_, scene_load, flow, contact, times_);
  return std::make_unique<Step>(motion_, state_, scene_load, seen_, flow, contact, times_);
}

void Simulation::advance_reduced() {
  const ModalMotion& motion = reduced_->motion();
  const double h = motion.step();
  State& now = next_state_;
  ReducedModel::Taken taken =
      reduced_->step(state_, loads_.at(time() + (1 + motion.scheme().alpha) * h), times_, now);
  const Stopwatch watch(times_.record);
  StepRecord record;
  record.time = static_cast<double>(now.step) * h;
  record.iterations = 1;
  record.flow = std::move(taken.flow);
  record.contact = std::move(taken.contact);
  const bool look = now.step % scene_.reduction->watch_every == 0 || !state_.watched;
  Points x;
  if (look) {
    const Vector displacement = motion.at_unknowns(now.displacement);
    x = scene_.mesh.points + as_points(motion_.everywhere(displacement));
    now.watched = Watched{tissue_.strains(displacement), {}};
    now.watched->inverted_by_layer = tissue_.folded_since(x);
    if (reduced_->contact()) reduced_->contact()->require_open_beyond(now, x);
  } else {
    now.watched = state_.watched;
  }
  record.strains = now.watched->strains;
  record.inverted_by_layer = now.watched->inverted_by_layer;
  record.inverted_tissue = record.inverted_by_layer.sum();
  if (!look && record.inverted_tissue > 0 && !now.first_signs.folded_tissue) x = positions();
  now.first_signs.note(now.step, record, x, scene_.mesh.cells);
  std::swap(state_, next_state_);
  record_ = std::move(record);
}

void Simulation::keep(State now, const std::optional<FlowRecord>& flow, const Vector& scene_load,
                      NodalStep& step) {
  {
    const Stopwatch watch(times_.ledger);
    if (flow) {
      now.flow_load = now.load - scene_load;
      now.supplied_power = flow->state.supplied_power;
      now.viscous_power = flow->state.viscous_power;
      now.inertial_power = flow->state.inertial_power;
    }
    now.ledger = explicit_ ? explicit_->continued_ledger(state_, now) : continued_ledger(motion_, state_, now);
  }
  const Stopwatch watch(times_.record);
  const Points x = motion_.positions(now.displacement);
  StepRecord record;
  record.time = static_cast<double>(now.step) * motion_.step();
  record.iterations = step.iterations();
  record.force_evaluations = step.evaluations();
  record.flow = flow;
  record.strains = tissue_.strains(now.displacement);
  record.inverted_by_layer = tissue_.folded_since(x);
  record.inverted_tissue = record.inverted_by_layer.sum();
  if (contact_) {
    const double before = contact_->collision().detection_time();
    contact_->update_pressure(now, x);
    record.contact =
        contact_->record(step.contacts(), step.x_previous(), state_.depth, now, x, record.inverted_tissue > 0);
    now.depth = -record.contact->deepest_gap;
    detection_of_records_ += contact_->collision().detection_time() - before;
  }
  const bool at_origin = motion_.origin().isZero(0);
  now.first_signs.note(now.step, record, at_origin ? x : motion_.in_scene(x), scene_.mesh.cells);
  now.past = std::move(state_.past);
  if (Vector image = step.take_image(); image.size() > 0) now.past.add(now.acceleration, std::move(image));
  state_ = std::move(now);
  record_ = record;
}

}  // namespace plica

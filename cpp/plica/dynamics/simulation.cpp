#include "plica/dynamics/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "plica/core/error.hpp"
#include "plica/dynamics/step.hpp"

namespace plica {

namespace {

constexpr double pi = 3.14159265358979323846;

/// Nodes of the two sides of a contact, ascending.
/// A node that is held does not move, so its mass does no harm: it stays.
std::vector<std::int32_t> massless_nodes(const Scene& scene) {
  if (!scene.contact || scene.contact->surface_mass == SurfaceMass::kept) return {};
  std::vector<std::int32_t> nodes = surface_nodes(scene.contact->airway);
  const auto held = [&](std::int32_t node) { return scene.supports.node_fixed(node); };
  nodes.erase(std::remove_if(nodes.begin(), nodes.end(), held), nodes.end());
  return nodes;
}

NodalMatrix assemble_mass(const Assembler& assembler, const Tissue& tissue, Simulation::Mass kind,
                          const std::vector<std::int32_t>& massless) {
  if (!massless.empty()) {
    std::vector<char> marked(static_cast<std::size_t>(assembler.pattern()->rows()), 0);
    for (const auto node : massless) marked[static_cast<std::size_t>(node)] = 1;
    return assembler.redistributed_mass(tissue, kind, marked);
  }
  if (kind == Simulation::Mass::consistent) return assembler.mass(tissue);
  const Vector lumped = assembler.lumped_mass(tissue);
  NodalMatrix mass(assembler.pattern());
  for (std::int32_t i = 0; i < lumped.size(); ++i) mass.values()[assembler.pattern()->find(i, i)] = lumped[i];
  return mass;
}

std::optional<BlockMatrix> assemble_viscosity(const Assembler& assembler, const Tissue& tissue) {
  const bool viscous = std::any_of(tissue.materials.begin(), tissue.materials.end(),
                                   [](const Material& m) { return m.viscosity > 0; });
  if (!viscous) return std::nullopt;
  return assembler.viscosity(tissue);
}

/// Friction needs the compliance of its rows, and the rows of Nitsche's method are far from symmetric: condensed.
ContactSolver solver_of(const ContactPart& part, std::ptrdiff_t surface_nodes) {
  if (part.friction || std::holds_alternative<Nitsche>(part.enforcement)) return Condensed{};
  const auto* multipliers = std::get_if<Multipliers>(&part.enforcement);
  return chosen_solver(multipliers ? multipliers->solver : Automatic{}, surface_nodes);
}

BlockMatrix assemble_step_matrix(const SchemeCoefficients& s, double h, const NodalMatrix& M,
                                 const std::optional<BlockMatrix>& C, const BlockMatrix& K,
                                 const Supports& supports) {
  return combine_matrices(1.0, M, (1 + s.alpha) * s.gamma * h, C, (1 + s.alpha) * s.beta * h * h, K, supports);
}

Scene checked(Scene scene) {
  scene.validate();
  scene.mesh = labelled(std::move(scene.mesh));
  return scene;
}

Simulation::Options checked(Simulation::Options options) {
  options.validate();
  return options;
}

}  // namespace

void Simulation::Options::validate() const {
  coefficients(scheme);
  if (!(step > 0) || !std::isfinite(step)) throw InvalidInput("Simulation", "step", step, "s", "> 0 and finite");
  solver.validate();
}

Simulation::Simulation(Scene scene, Options options)
    : scene_(checked(std::move(scene))),
      options_(checked(options)),
      scheme_(coefficients(options_.scheme)),
      origin_(origin_near(scene_.mesh.points)),
      reference_(scene_.mesh.points.rowwise() - origin_.transpose()),
      assembler_(scene_.mesh),
      massless_(massless_nodes(scene_)),
      mass_(assemble_mass(assembler_, scene_.tissue, options_.mass, massless_)),
      stiffness_(assembler_.stiffness(scene_.tissue)),
      viscosity_(assemble_viscosity(assembler_, scene_.tissue)),
      step_matrix_(assemble_step_matrix(scheme_, options_.step, mass_, viscosity_, stiffness_, scene_.supports)),
      solver_(step_matrix_, options_.solver) {
  const std::ptrdiff_t n = scene_.mesh.node_count();
  for (const Load& load : scene_.loads)
    load_vectors_.push_back(assembler_.traction(scene_.mesh.surface(load.surface), load.traction));
  if (scene_.gravity) constant_load_ = assembler_.body_force(scene_.tissue, *scene_.gravity);
  if (scene_.airflow)
    airflow_.emplace(scene_.mesh, scene_.mesh.surface(scene_.airflow->surface), scene_.airflow->flow);
  if (scene_.contact) {
    ContactPart& part = *scene_.contact;
    std::vector<std::int32_t> nodes = surface_nodes(part.airway);
    if (scene_.airflow) {  // sections and loads of a step in the making need its contact response too
      const Faces& surface = scene_.mesh.surface(scene_.airflow->surface);
      nodes.insert(nodes.end(), surface.data(), surface.data() + surface.size());
    }
    if (std::holds_alternative<Nitsche>(part.enforcement)) {
      node_stress_.emplace(scene_.mesh, scene_.tissue, nodes);
      for (const std::int32_t node : std::vector<std::int32_t>(nodes))
        for (const NodeStress::Term& term : node_stress_->at(node)) nodes.push_back(term.node);
    }
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    const Indices interface_nodes = Eigen::Map<Indices>(nodes.data(), static_cast<std::ptrdiff_t>(nodes.size()));
    contact_solver_ = solver_of(part, interface_nodes.size());
    collision_.emplace(
        part.airway, reference_, part.enforcement, part.friction, part.options,
        contact_path(*contact_solver_, step_matrix_, scene_.supports, interface_nodes, options_.solver),
        part.faces);
    overlap_.emplace(scene_.mesh.cells, collision_->detector());
  }

  state_.displacement = scene_.displacement ? Vector(as_vector(*scene_.displacement)) : Vector::Zero(3 * n);
  state_.velocity = scene_.velocity ? Vector(as_vector(*scene_.velocity)) : Vector::Zero(3 * n);
  scene_.supports.project(state_.displacement);
  scene_.supports.project(state_.velocity);
  if (collision_) state_.contact_force = Vector::Zero(3 * n);
  state_.load = scene_load(0.0);
  if (airflow_) {
    const Points x = positions();  // as the flow knows them
    airflow_->add_load(x, airflow_->evaluate(airflow_->areas(x), false).pressure, state_.load);
  }
  state_.elastic_force = stiffness_ * state_.displacement;
  StartForces forces{state_.load - state_.elastic_force, Vector::Zero(3 * n)};
  if (viscosity_) forces.viscous = -(*viscosity_ * state_.velocity);
  Supports without_acceleration = scene_.supports;
  for (const auto node : massless_) without_acceleration.fix(node);
  without_acceleration.project(forces.elastic_and_load);
  without_acceleration.project(forces.viscous);
  start_ = start_motion(scheme_, options_.step, {mass_, viscosity_, stiffness_, without_acceleration}, forces,
                        options_.solver);
  state_.acceleration = start_.acceleration;
  state_.weighted_elastic_force = stiffness_ * Vector(state_.displacement + start_.displacement);
  if (viscosity_) state_.viscous_force = *viscosity_ * Vector(state_.velocity + start_.velocity);
  state_.inertial_force = mass_ * state_.acceleration;
  Ledger& ledger = state_.ledger;
  ledger.kinetic = 0.5 * state_.velocity.dot(mass_ * state_.velocity);
  ledger.elastic = 0.5 * state_.displacement.dot(state_.elastic_force);
  ledger.initial = ledger.kinetic + ledger.elastic;
  if (collision_) start_apart();
  StepRecord start;
  start.inverted_tissue = static_cast<int>(folded_cells(positions(), scene_.mesh.cells));
  state_.first_signs.note(0, start, positions(), scene_.mesh.cells);
}

Simulation::~Simulation() = default;

/// Surfaces that overlap at t = 0 would be thrown apart by a force that nothing has done work for.
void Simulation::start_apart() {
  Detector& detector = collision_->detector();
  const Points x = positions_from_origin();
  const auto place = [&, at = in_scene(x)](std::int32_t node) {
    return "(" + number(at(node, 0)) + ", " + number(at(node, 1)) + ", " + number(at(node, 2)) + ") m";
  };
  if (detector.airway().renewed) {
    const double deep = scene_.contact->options.tolerance;
    if (const auto inside = node_in_tissue(x, scene_.mesh.cells, detector.nodes(), deep))
      throw InvalidInput("Scene: node " + std::to_string(*inside) + " of the contact surfaces at " +
                         place(*inside) + " lies in the tissue; must be outside at t = 0. Move the bodies apart.");
  }
  detector.update(x);
  const auto [node, gap] = detector.deepest(x, detector.reach(reference_, x, 0.0));
  if (-gap > scene_.contact->options.tolerance * detector.mean_edge())
    throw InvalidInput("Scene", "gap at node " + std::to_string(node) + " displaced to " + place(node), gap, "m",
                       ">= 0 at t = 0", "Reduce the initial displacement.");
}

StepTimes Simulation::times() const {
  StepTimes times = times_;
  if (collision_) {
    times.detection = collision_->detection_time();
    times.contact -= times.detection;
  }
  return times;
}

Points Simulation::positions() const { return scene_.mesh.points + as_points(state_.displacement); }

void Simulation::set_external_force(Vector force) {
  if (force.size() != step_matrix_.rows())
    throw InvalidInput("Simulation", "external force", static_cast<double>(force.size()), "entries",
                       "3 times the " + std::to_string(scene_.mesh.node_count()) + " nodes");
  external_force_ = std::move(force);
}

void Simulation::restore(State state) {
  const std::pair<const char*, const Vector*> fields[] = {
      {"displacement", &state.displacement},
      {"velocity", &state.velocity},
      {"acceleration", &state.acceleration},
      {"load", &state.load},
      {"contact_force", &state.contact_force},
      {"elastic_force", &state.elastic_force},
      {"weighted_elastic_force", &state.weighted_elastic_force},
      {"viscous_force", &state.viscous_force},
      {"inertial_force", &state.inertial_force}};
  for (const auto& [name, values] : fields) {
    const bool absent =
        (values == &state.contact_force && !collision_) || (values == &state.viscous_force && !viscosity_);
    const std::ptrdiff_t size = absent ? 0 : step_matrix_.rows();
    if (values->size() != size)
      throw InvalidInput("Simulation", std::string("size of the state's ") + name,
                         static_cast<double>(values->size()), "", std::to_string(size),
                         "It belongs to another scene.");
    if (!values->allFinite())
      throw InvalidInput(std::string("Simulation: the state's ") + name + " has a value that is not finite.");
  }
  if (state.step < 0)
    throw InvalidInput("Simulation", "state's step", static_cast<double>(state.step), "", ">= 0");
  if (state.closed_force.size() != static_cast<std::ptrdiff_t>(state.closed.size()))
    throw InvalidInput("Simulation", "size of the state's closed_force",
                       static_cast<double>(state.closed_force.size()), "",
                       "that of closed, " + std::to_string(state.closed.size()));
  for (std::size_t i = 0; i < state.closed.size(); ++i)
    if (!(state.closed_force[static_cast<std::ptrdiff_t>(i)] > 0) || (i && state.closed[i] <= state.closed[i - 1]))
      throw InvalidInput("Simulation: the state's closed constraints must ascend, each with a force > 0 N.");
  if (collision_)
    for (const std::int32_t key : state.closed)
      if (!collision_->knows(key))
        throw InvalidInput("Simulation", "state's closed constraint", key, "", "one that this contact can have",
                           "It belongs to another scene.");
  if (!(state.depth >= 0) || !std::isfinite(state.depth))
    throw InvalidInput("Simulation", "state's depth", state.depth, "m", ">= 0 and finite");
  state.first_signs.validate(state.step, scene_.mesh.cell_count());
  state_ = std::move(state);
  record_ = StepRecord{};
  record_.time = time();
  if (collision_) update_contact_pressure(positions_from_origin());
}

Vector Simulation::scene_load(double t) const {
  Vector load = constant_load_.size() ? constant_load_ : Vector::Zero(step_matrix_.rows());
  for (std::size_t i = 0; i < load_vectors_.size(); ++i)
    load += std::cos(2 * pi * scene_.loads[i].frequency * t + scene_.loads[i].phase) * load_vectors_[i];
  if (external_force_.size()) load += external_force_;
  return load;
}

void Simulation::advance() {
  const auto seen_from = [&]() -> std::string {
    if (origin_.isZero(0)) return "";
    return " (Its places are seen from (" + number(origin_[0]) + ", " + number(origin_[1]) + ", " +
           number(origin_[2]) + ") m.)";
  };
  const auto failed = [&](const std::exception& failure) {
    const std::int64_t next = state_.step + 1;
    return SolveFailed("Step " + std::to_string(next) + " (t = " +
                       number(static_cast<double>(next) * options_.step) + " s): " + failure.what() + seen_from() +
                       state_.first_signs.text(options_.step, folded_cells(positions(), scene_.mesh.cells)));
  };
  try {
    Step step(*this);
    if (collision_) {
      const Stopwatch watch(times_.contact);
      collision_->renew(step.x_previous, step.depth_before);
    }
    couple(step);
    complete(step);
    finish(step);
  } catch (const SolveFailed& failure) {
    throw failed(failure);
  } catch (const InvalidInput& failure) {  // what was handed in is checked: positions that a step made diverge
    throw failed(failure);
  }
}

void Simulation::finish(Step& step) {
  const double h = options_.step;
  State previous = std::move(state_);
  state_ = State{};
  state_.step = previous.step + 1;
  state_.displacement = step.displacement_predictor + scheme_.beta * h * h * step.acceleration;
  state_.velocity = step.velocity_predictor + scheme_.gamma * h * step.acceleration;
  state_.acceleration = std::move(step.acceleration);
  state_.load = std::move(step.load);
  state_.contact_force = std::move(step.contact_force);
  std::tie(state_.closed, state_.closed_force) = step.contacts.closed();
  state_.flow_stopped = step.flow_stopped;
  state_.ledger = previous.ledger;
  state_.first_signs = previous.first_signs;
  {
    const Stopwatch watch(times_.ledger);
    update_ledger(previous);
  }
  record_ = StepRecord{};
  record_.time = time();
  record_.iterations = step.iterations;
  record_.flow = step.flow;
  const Stopwatch watch(times_.record);
  const Points x = positions_from_origin();
  record_.inverted_tissue = static_cast<int>(folded_cells(x, scene_.mesh.cells));
  if (collision_) {
    update_contact_pressure(x);
    record_.contact = contact_record(step, x);
    state_.depth = -record_.contact->deepest_gap;
  }
  if (origin_.isZero(0))
    state_.first_signs.note(state_.step, record_, x, scene_.mesh.cells);
  else
    state_.first_signs.note(state_.step, record_, in_scene(x), scene_.mesh.cells);
}

void Simulation::update_ledger(const State& before) {
  // dE = du . f_bar + du . contact_bar - du . C V_bar - D, D the scheme's own dissipation; docs/theory.md.
  const double h = options_.step, alpha = scheme_.alpha, beta = scheme_.beta, gamma = scheme_.gamma;
  const bool first = before.step == 0;
  State& now = state_;
  const Vector du = now.displacement - before.displacement;
  const Vector da = now.acceleration - before.acceleration;
  now.elastic_force = stiffness_ * now.displacement;
  now.weighted_elastic_force =
      (1 + alpha) * now.elastic_force - alpha * (first ? before.weighted_elastic_force : before.elastic_force);
  if (viscosity_) {
    Vector rate = (1 + alpha) * now.velocity - alpha * before.velocity;
    if (first) rate -= alpha * start_.velocity;
    now.viscous_force = *viscosity_ * rate;
  }
  now.inertial_force = mass_ * now.acceleration;

  Ledger& ledger = now.ledger;
  ledger.kinetic = 0.5 * now.velocity.dot(mass_ * now.velocity);
  ledger.elastic = 0.5 * now.displacement.dot(now.elastic_force);
  // Loads are those of t_{n+1+alpha}: -alpha times their difference further on is the load of the step's middle.
  const double late = (first ? alpha / (2 * (1 + alpha)) : alpha) * du.dot(now.load - before.load);
  ledger.load_work += 0.5 * du.dot(now.load + before.load) - late;
  if (collision_) ledger.contact_work += 0.5 * du.dot(now.contact_force + before.contact_force);
  if (viscosity_) ledger.viscous_loss += 0.5 * du.dot(now.viscous_force + before.viscous_force);
  const Vector d_inertia = now.inertial_force - before.inertial_force;
  ledger.numerical_loss +=
      -h * (gamma - 0.5) * 0.5 * (now.velocity + before.velocity).dot(d_inertia) +
      h * h * (beta - 0.5 * gamma) * 0.5 * da.dot(now.inertial_force + before.inertial_force) +
      0.5 * du.dot(now.weighted_elastic_force + before.weighted_elastic_force - now.elastic_force -
                   before.elastic_force) -
      late;
  if (!first) return;
  ledger.numerical_loss += 0.5 * start_.shift.dot(now.inertial_force + before.inertial_force);
  // What was out of balance at nodes without mass at t = 0 is so no more: they have moved at once.
  for (const auto node : massless_) {
    const std::ptrdiff_t at = 3 * static_cast<std::ptrdiff_t>(node);
    Vector3 force = before.load.segment<3>(at) - before.weighted_elastic_force.segment<3>(at);
    if (viscosity_) force -= before.viscous_force.segment<3>(at);
    ledger.numerical_loss += 0.5 * du.segment<3>(at).dot(force);
  }
}

}  // namespace plica

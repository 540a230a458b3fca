#include "plica/dynamics/scene_contact.hpp"

#include <algorithm>

#include "plica/core/error.hpp"
#include "plica/dynamics/contact_record.hpp"
#include "plica/dynamics/scene_flow.hpp"
#include "plica/dynamics/state.hpp"
#include "plica/dynamics/step.hpp"
#include "plica/dynamics/step_stress.hpp"

namespace plica {

namespace {

/// Whether the surfaces are each other's image in the plane x = 0, and not each its own.
bool are_images(const Detector& detector, const MirrorImages& images) {
  const std::vector<std::int32_t>& nodes = detector.first().nodes();
  return std::all_of(nodes.begin(), nodes.end(),
                     [&](std::int32_t node) { return detector.second().contains(images.partner(0, node)); });
}

}  // namespace

SceneContact::SceneContact(const Scene& scene, const Motion& motion) : scene_(scene), motion_(motion) {
  const ContactPart& part = *scene.contact;
  std::unique_ptr<ContactMethod> method = contact_method(part.enforcement);
  std::vector<std::int32_t> nodes = surface_nodes(part.airway);
  if (scene.airflow) {  // sections and loads of a step in the making need its contact response too
    const Faces& surface = scene.mesh.surface(scene.airflow->surface);
    nodes.insert(nodes.end(), surface.data(), surface.data() + surface.size());
  }
  if (method->needs_stress()) {
    node_stress_.emplace(scene.mesh, scene.tissue, nodes);
    for (const std::int32_t node : std::vector<std::int32_t>(nodes))
      for (const NodeStress::Term& term : node_stress_->at(node)) nodes.push_back(term.node);
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  nodes_ = Eigen::Map<Indices>(nodes.data(), static_cast<std::ptrdiff_t>(nodes.size()));
  std::unique_ptr<ForceSolver> solver;
  if (!motion.solves()) {
    solver = explicit_solver();
  } else {
    const MirrorImages* images = motion.images();
    solver_ = chosen_solver(method->solver(part.friction.has_value()), nodes_.size());
    solver = force_solver(*solver_, motion.step_matrix(), motion.solver(), motion.supports(),
                          images ? images->nodes_of(nodes_) : nodes_, motion.options().solver.krylov());
    if (images) solver = mirrored_solver(std::move(solver), *images, nodes_);
  }
  collision_.emplace(part.airway, motion.reference(), std::move(method), part.friction, part.options,
                     std::move(solver), part.faces);
  collision_->hold_facing(motion.reference(),
                          motion.images() && are_images(collision_->detector(), *motion.images()));
  overlap_.emplace(scene.mesh.cells, collision_->detector(), motion.reference());
}

void SceneContact::require_apart(const Points& x) {
  Detector& detector = collision_->detector();
  const ContactPart& part = *scene_.contact;
  const auto place = [&, at = motion_.in_scene(x)](std::int32_t node) {
    return "(" + number_text(at(node, 0)) + ", " + number_text(at(node, 1)) + ", " + number_text(at(node, 2)) +
           ") m";
  };
  if (detector.airway().renewed)
    if (const auto inside = node_in_tissue(x, scene_.mesh.cells, detector.nodes(), part.options.tolerance))
      throw InvalidInput("Scene: node " + std::to_string(*inside) + " of the contact surfaces at " +
                         place(*inside) + " lies in the tissue; must be outside at t = 0. Move the bodies apart.");
  detector.update(x);
  const auto [node, gap] = detector.deepest(x, detector.reach(motion_.reference(), x, 0.0));
  if (-gap > part.options.tolerance * detector.mean_edge())
    throw InvalidInput("Scene", "gap at node " + std::to_string(node) + " displaced to " + place(node), gap, "m",
                       ">= 0 at t = 0", "Reduce the initial displacement.");
}

void SceneContact::begin(const Points& x, double depth) {
  collision_->forget();
  collision_->renew(x, depth);
}

Contacts SceneContact::solve(const Step& step, Contacts known, Points& x) {
  const auto [alpha, beta, gamma] = motion_.scheme();
  const double h = motion_.step(), weight = 1 + alpha;
  const State& last = step.last();
  std::optional<StepStress> stress;
  if (node_stress_)
    stress.emplace(*node_stress_, motion_.reference(), step.displacement_behind(), step.velocity_behind(),
                   step.displacement_predictor(), step.velocity_predictor(), motion_.scheme(), h);
  const BeforeContact before{step.x_previous(), last.closed, last.closed_force, last.depth,
                             stress ? &*stress : nullptr};
  if (std::holds_alternative<EndOfStep>(collision_->method().position()))
    return collision_->solve(step.x(), beta * h * h, before, std::move(known), x);
  Contacts contacts =
      collision_->solve(step.weighted_positions(), weight * beta * h * h, before, std::move(known), x);
  x = (x + alpha * step.x_previous()) / weight;
  return contacts;
}

Contacts SceneContact::forces_at(const Points& x, const Points& x_previous, const State& last) {
  Points unmoved;
  return collision_->solve(x, 0.0, {x_previous, last.closed, last.closed_force, last.depth}, {}, unmoved);
}

bool SceneContact::blocks(const SceneFlow& flow, const Contacts& contacts, const Points& x,
                          const Points& x_previous, double depth) const {
  if (!flow.airflow().stops_at_contact()) return false;
  for (std::size_t i = 0; i < contacts.constraints.size(); ++i) {
    if (!(contacts.force[static_cast<std::ptrdiff_t>(i)] > 0)) continue;
    if (flow.blocks(x.row(contacts.constraints[i].slave))) return true;
  }
  const Detector& detector = collision_->detector();
  const auto crossings = detector.edge_crossings(x, detector.reach(x_previous, x, depth));
  return std::any_of(crossings.begin(), crossings.end(),
                     [&](const EdgeCrossing& crossing) { return flow.blocks(crossing.place); });
}

ContactRecord SceneContact::record(const Contacts& contacts, const Points& x_previous, double depth,
                                   const State& now, const Points& x, bool folded) {
  const Vector force = motion_.shared(now.contact_force);
  ContactRecord record =
      contact_record(*collision_, contacts, x_previous, collision_->detector().reach(x_previous, x, depth),
                     {force, now.closed, now.closed_force}, x);
  // A folded cell holds nodes of its own side, too.
  if (!folded) record.deepest_gap = std::min(record.deepest_gap, -overlap_->depth(x, collision_->detector()));
  return record;
}

void SceneContact::update_pressure(const State& state, const Points& x) {
  collision_->update(x);
  pressure_ = collision_->pressure({motion_.shared(state.contact_force), state.closed, state.closed_force}, x);
}

}  // namespace plica

#include "plica/dynamics/scene.hpp"

#include <cmath>

#include "plica/core/error.hpp"
#include "plica/tissue/stretch_law.hpp"

namespace plica {

void AirflowPart::validate() const {
  const auto* iterated = std::get_if<Iterated>(&coupling);
  if (!iterated) return;
  iterated->validate();
  if (std::holds_alternative<Bernoulli>(flow.model) && iterated->max_sweeps <= iterated->freeze_after)
    throw InvalidInput("Iterated", "max_sweeps", iterated->max_sweeps, "",
                       "> freeze_after = " + std::to_string(iterated->freeze_after) + " with Bernoulli's flow",
                       "What is held needs a sweep.");
}

void Load::validate() const {
  for (int d = 0; d < 3; ++d)
    if (!std::isfinite(traction[d]))
      throw InvalidInput("Load", std::string("traction.") + "xyz"[d], traction[d], "Pa", "finite");
  if (!(frequency >= 0) || !std::isfinite(frequency))
    throw InvalidInput("Load", "frequency", frequency, "Hz", ">= 0 and finite");
  if (!std::isfinite(phase)) throw InvalidInput("Load", "phase", phase, "rad", "finite");
}

namespace {

/// What moves by forces of tissue that are not linear in its displacement.
void refuse_beside_finite_strain(const Scene& scene) {
  scene.strain->validate();
  const auto refuse = [](const std::string& what) { throw InvalidInput("Scene: strain = finite with " + what); };
  if (scene.reduction) refuse("a reduction; must be without: a basis spans motion about one stiffness.");
  if (scene.contact && std::holds_alternative<Nitsche>(scene.contact->enforcement))
    refuse("contact by Nitsche's method; must be another: it takes the stress of linear tissue.");
  if (scene.contact && scene.contact->surface_mass == SurfaceMass::redistributed)
    refuse(
        "contact.surface_mass = \"redistributed\"; must be \"kept\": massless nodes start as linear tissue does.");
  for (const Material& material : scene.tissue.materials) StretchLaw{material};
}

}  // namespace

void Scene::validate() const {
  check_mesh(mesh);
  tissue.validate(mesh);
  const std::ptrdiff_t n = mesh.node_count();
  if (supports.size() != 3 * n)
    throw InvalidInput("Scene", "supports", static_cast<double>(supports.size()), "unknowns",
                       "3 times the " + std::to_string(n) + " nodes");
  if (airflow) airflow->validate();
  if (contact) {
    const auto check_nodes = [&](const auto& rows, const char* name) {
      for (const std::int32_t node : rows.reshaped())
        if (node < 0 || node >= n)
          throw InvalidInput("Scene", name, node, "", "in [0, " + std::to_string(n) + ")",
                             "The airway belongs to another mesh.");
    };
    check_nodes(contact->airway.first, "node of a contact surface");
    check_nodes(contact->airway.second, "node of a contact surface");
    check_nodes(contact->airway.tets, "node of the air");
  }
  for (const Load& load : loads) load.validate();
  if (gravity && !gravity->allFinite())
    throw InvalidInput("Scene: gravity has a value that is not finite; must be finite.");
  const auto check_field = [&](const std::optional<Points>& field, const char* name) {
    if (!field) return;
    if (field->rows() != n)
      throw InvalidInput("Scene", name, static_cast<double>(field->rows()), "rows",
                         "one row a node (" + std::to_string(n) + ")");
    if (!field->allFinite())
      throw InvalidInput(std::string("Scene: ") + name + " has a value that is not finite.");
  };
  check_field(displacement, "displacement");
  check_field(velocity, "velocity");
  if (reduction) reduction->validate(n);
  if (strain) refuse_beside_finite_strain(*this);
}

}  // namespace plica

#include "dynamics_state.hpp"

#include <algorithm>

namespace plica::python {

namespace {

/// Calls visit(name, member) for every nodal vector of a State.
template <typename AnyState, typename Visit>
void for_vectors(AnyState& state, const Visit& visit) {
  visit("displacement", state.displacement);
  visit("velocity", state.velocity);
  visit("acceleration", state.acceleration);
  visit("load", state.load);
  visit("contact_force", state.contact_force);
  visit("flow_load", state.flow_load);
  visit("elastic_force", state.elastic_force);
  visit("weighted_elastic_force", state.weighted_elastic_force);
  visit("viscous_force", state.viscous_force);
  visit("inertial_force", state.inertial_force);
  visit("stiffness_velocity", state.stiffness_velocity);
  visit("stiffness_acceleration", state.stiffness_acceleration);
  visit("viscosity_velocity", state.viscosity_velocity);
  visit("viscosity_acceleration", state.viscosity_acceleration);
}

/// Those of tissue at finite strain alone.
template <typename AnyState, typename Visit>
void for_excess(AnyState& state, const Visit& visit) {
  visit("elastic_excess", state.elastic_excess);
  visit("viscous_excess", state.viscous_excess);
}

template <typename AnyLedger, typename Visit>
void for_energies(AnyLedger& ledger, const Visit& visit) {
  visit("kinetic", ledger.kinetic);
  visit("elastic", ledger.elastic);
  visit("load_work", ledger.load_work);
  visit("flow_work", ledger.flow_work);
  visit("contact_work", ledger.contact_work);
  visit("viscous_loss", ledger.viscous_loss);
  visit("numerical_loss", ledger.numerical_loss);
  visit("initial", ledger.initial);
  visit("air_supplied_energy", ledger.air_supplied_energy);
  visit("air_viscous_energy", ledger.air_viscous_energy);
}

/// The first signs of trouble as numbers, none where there is none, and back.
using Numbers = std::vector<double>;

template <typename AnySigns, typename Visit>
void for_signs(AnySigns& signs, const Visit& visit) {
  visit("unconverged_coupling", signs.coupling);
  visit("unconverged_contact", signs.contact);
  visit("folded_tissue", signs.folded_tissue);
}

Numbers numbers_of(const Unconverged& sign) { return {static_cast<double>(sign.step), sign.left}; }
Numbers numbers_of(const FoldedTissue& sign) {
  return {static_cast<double>(sign.step),
          static_cast<double>(sign.count),
          static_cast<double>(sign.cell),
          sign.place[0],
          sign.place[1],
          sign.place[2]};
}
Unconverged sign_of(const Numbers& n, const Unconverged&) { return {static_cast<std::int64_t>(n.at(0)), n.at(1)}; }
FoldedTissue sign_of(const Numbers& n, const FoldedTissue&) {
  return {static_cast<std::int64_t>(n.at(0)), static_cast<std::int64_t>(n.at(1)),
          static_cast<std::int32_t>(n.at(2)), Vector3(n.at(3), n.at(4), n.at(5))};
}

Numbers numbers_of(const Watched& watched) {
  const Strains& s = watched.strains;
  Numbers numbers{s.strain,   s.neglected, s.largest, static_cast<double>(s.cell),
                  s.place[0], s.place[1],  s.place[2]};
  numbers.insert(numbers.end(), watched.inverted_by_layer.begin(), watched.inverted_by_layer.end());
  return numbers;
}
Watched watched_of(const Numbers& n) {
  if (n.size() < 7)
    throw InvalidInput("Simulation", "size of the state's watched", static_cast<double>(n.size()), "", ">= 7");
  Watched watched{
      {n.at(0), n.at(1), n.at(2), static_cast<std::int32_t>(n.at(3)), Vector3(n.at(4), n.at(5), n.at(6))},
      Indices(static_cast<std::ptrdiff_t>(n.size()) - 7)};
  std::transform(n.begin() + 7, n.end(), watched.inverted_by_layer.begin(),
                 [](double count) { return static_cast<std::int32_t>(count); });
  return watched;
}

/// Vectors of one length as the rows of an array, and back.
py::array_t<double> rows_of(const std::vector<Vector>& vectors) {
  const auto length = vectors.empty() ? 0 : static_cast<py::ssize_t>(vectors.front().size());
  py::array_t<double> rows({static_cast<py::ssize_t>(vectors.size()), length});
  for (std::size_t k = 0; k < vectors.size(); ++k)
    std::copy(vectors[k].begin(), vectors[k].end(), rows.mutable_data() + static_cast<py::ssize_t>(k) * length);
  return rows;
}
std::vector<Vector> vectors_of(const RealArray& rows) {
  std::vector<Vector> vectors;
  if (rows.ndim() != 2) wrong_shape("Simulation", "the state's past", rows, "(steps, unknowns)");
  for (py::ssize_t k = 0; k < rows.shape(0); ++k)
    vectors.emplace_back(Eigen::Map<const Vector>(rows.data(k, 0), rows.shape(1)));
  return vectors;
}

/// (steps, ...) of what was recorded, without a copy of real numbers; whole ones become int32.
py::array to_array(Recorder::Column& column) {
  std::vector<py::ssize_t> shape(column.shape.begin(), column.shape.end());
  shape.insert(shape.begin(), column.steps);
  if (column.waveform.whole) {
    py::array_t<std::int32_t> whole(shape);
    std::copy(column.values.begin(), column.values.end(), whole.mutable_data());
    return whole;
  }
  auto* kept = new std::vector<double>(std::move(column.values));
  const py::capsule owner(kept, [](void* pointer) { delete static_cast<std::vector<double>*>(pointer); });
  return py::array_t<double>(shape, kept->data(), owner);
}

py::dict to_dict(std::vector<Recorder::Column> columns) {
  py::dict dict;
  for (Recorder::Column& column : columns) dict[column.waveform.name.c_str()] = to_array(column);
  return dict;
}

}  // namespace

py::dict state_to_dict(const State& state) {
  py::dict dict;
  dict["step"] = state.step;
  for_vectors(state, [&](const char* name, const Vector& v) { dict[name] = give(Vector(v)); });
  if (state.elastic_excess.size() > 0) {
    for_excess(state, [&](const char* name, const Vector& v) { dict[name] = give(Vector(v)); });
    dict["nonlinear_loss"] = state.ledger.nonlinear_loss;
  }
  dict["past_accelerations"] = rows_of(state.past.accelerations);
  dict["past_images"] = rows_of(state.past.images);
  dict["closed"] = py::array_t<std::int32_t>(static_cast<py::ssize_t>(state.closed.size()), state.closed.data());
  dict["closed_force"] = give(Vector(state.closed_force));
  if (state.interface_force.size() > 0) dict["interface_force"] = give(Vector(state.interface_force));
  if (state.watched) dict["watched"] = py::array_t<double>(py::cast(numbers_of(*state.watched)));
  dict["depth"] = state.depth;
  dict["air_column"] = py::array_t<double>(py::cast(state.air.numbers()));
  dict["supplied_power"] = state.supplied_power;
  dict["viscous_power"] = state.viscous_power;
  if (state.air.momentum.size() > 0) {
    dict["inertial_power"] = state.inertial_power;
    dict["air_inertial_energy"] = state.ledger.air_inertial_energy;
  }
  for_energies(state.ledger, [&](const char* name, double value) { dict[name] = value; });
  for_signs(state.first_signs, [&](const char* name, const auto& sign) {
    const Numbers numbers = sign ? numbers_of(*sign) : Numbers{};
    dict[name] = py::array_t<double>(static_cast<py::ssize_t>(numbers.size()), numbers.data());
  });
  return dict;
}

State state_from_dict(const py::dict& dict) {
  State state;
  const auto entry = [&](const char* name) -> py::object {
    if (!dict.contains(name))
      throw InvalidInput(std::string("Simulation: state lacks \"") + name +
                         "\"; it must be one that state() gave.");
    return dict[name];
  };
  state.step = entry("step").cast<std::int64_t>();
  for_vectors(state, [&](const char* name, Vector& v) { v = entry(name).cast<Vector>(); });
  if (dict.contains("elastic_excess")) {
    for_excess(state, [&](const char* name, Vector& v) { v = entry(name).cast<Vector>(); });
    state.ledger.nonlinear_loss = entry("nonlinear_loss").cast<double>();
  }
  state.past = {vectors_of(entry("past_accelerations").cast<RealArray>()),
                vectors_of(entry("past_images").cast<RealArray>())};
  for (const py::handle key : entry("closed")) state.closed.push_back(key.cast<std::int32_t>());
  state.closed_force = entry("closed_force").cast<Vector>();
  if (dict.contains("interface_force")) state.interface_force = entry("interface_force").cast<Vector>();
  if (dict.contains("watched")) state.watched = watched_of(entry("watched").cast<Numbers>());
  state.depth = entry("depth").cast<double>();
  state.air = AirColumn::Memory::of(entry("air_column").cast<std::vector<double>>());
  state.supplied_power = entry("supplied_power").cast<double>();
  state.viscous_power = entry("viscous_power").cast<double>();
  for_energies(state.ledger, [&](const char* name, double& value) { value = entry(name).cast<double>(); });
  if (state.air.momentum.size() > 0) {
    state.inertial_power = entry("inertial_power").cast<double>();
    state.ledger.air_inertial_energy = entry("air_inertial_energy").cast<double>();
  }
  for_signs(state.first_signs, [&](const char* name, auto& sign) {
    using Sign = typename std::decay_t<decltype(sign)>::value_type;
    const auto numbers = entry(name).cast<Numbers>();
    if (numbers.empty()) return;
    if (numbers.size() != numbers_of(Sign{}).size())
      throw InvalidInput("Simulation", std::string("size of the state's ") + name,
                         static_cast<double>(numbers.size()), "",
                         "0 or " + std::to_string(numbers_of(Sign{}).size()));
    sign = sign_of(numbers, Sign{});
  });
  return state;
}

py::dict SteppedSimulation::advance(int steps, const std::optional<std::vector<std::string>>& waveforms) {
  if (steps < 0) throw InvalidInput("Simulation", "steps", steps, "", ">= 0");
  Recorder recorder(simulation_, waveforms ? *waveforms : waveforms_of(simulation_.scene()), probes_);
  recorder.reserve(steps);
  std::optional<SolveFailed> failure;
  {
    const py::gil_scoped_release released;
    try {
      for (int k = 0; k < steps; ++k) {
        simulation_.advance();
        recorder.add();
      }
    } catch (const SolveFailed& caught) {
      failure = caught;
    }
  }
  py::dict recorded = to_dict(recorder.take());
  if (!failure) return recorded;
  const py::object kind = py::module_::import("plica.errors").attr("StepFailed");
  const py::object error = kind(failure->what(), recorded);
  PyErr_SetObject(kind.ptr(), error.ptr());
  throw py::error_already_set();
}

py::dict SteppedSimulation::info() const {
  const Scene& scene = simulation_.scene();
  py::dict info;
  info["nodes"] = scene.mesh.node_count();
  info["cells"] = scene.mesh.cell_count();
  info["order"] = scene.mesh.order();
  info["fixed_unknowns"] = scene.supports.fixed_count();
  info["unknowns"] = 3 * scene.mesh.node_count() - scene.supports.fixed_count();
  info["matrix_bytes"] = simulation_.stiffness().values().size() * sizeof(double);
  info["linear_solver"] = simulation_.linear_solver();
  if (const ReducedModel* reduced = simulation_.reduced()) {
    info["coordinates"] = reduced->motion().size();
    info["contact_nodes"] = reduced->contact() ? reduced->contact()->nodes().size() : 0;
  }
  if (simulation_.airflow()) info["sections"] = simulation_.airflow()->sections().count();
  if (simulation_.collision()) {
    info["airway_tetrahedra"] = simulation_.collision()->detector().airway().tets.rows();
    const ContactSolver* solver = simulation_.contact_solver();
    info["contact_solver"] = solver ? name_of(*solver) : "none";
  }
  return info;
}

std::optional<py::array_t<std::int32_t>> SteppedSimulation::images() const {
  const MirrorImages* images = simulation_.images();
  if (!images) return std::nullopt;
  py::array_t<std::int32_t> nodes({static_cast<py::ssize_t>(images->copies()), images->nodes().size()});
  for (int copy = 0; copy < images->copies(); ++copy)
    for (std::int32_t own = 0; own < images->nodes().size(); ++own)
      nodes.mutable_at(copy, own) = images->image(copy, own);
  return nodes;
}

py::dict SteppedSimulation::times() const {
  const StepTimes t = simulation_.times();
  py::dict times;
  times["residual"] = t.residual;
  times["load"] = t.load;
  if (simulation_.scene().strain) times["tissue"] = t.tissue;
  times["solve"] = t.solve;
  times["detection"] = t.detection;
  times["contact"] = t.contact;
  times["energies"] = t.ledger;
  times["record"] = t.record;
  return times;
}

const Sections& SteppedSimulation::sections() const {
  if (!simulation_.airflow()) throw InvalidInput("Simulation: there is no airflow in this scene, so no sections.");
  return simulation_.airflow()->sections();
}

}  // namespace plica::python

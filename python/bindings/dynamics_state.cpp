#include "dynamics_state.hpp"

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
  visit("elastic_force", state.elastic_force);
  visit("weighted_elastic_force", state.weighted_elastic_force);
  visit("viscous_force", state.viscous_force);
  visit("inertial_force", state.inertial_force);
}

template <typename AnyLedger, typename Visit>
void for_energies(AnyLedger& ledger, const Visit& visit) {
  visit("kinetic", ledger.kinetic);
  visit("elastic", ledger.elastic);
  visit("load_work", ledger.load_work);
  visit("contact_work", ledger.contact_work);
  visit("viscous_loss", ledger.viscous_loss);
  visit("numerical_loss", ledger.numerical_loss);
  visit("initial", ledger.initial);
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

/// Named columns of one number a step, or of a fixed-size row a step.
class Table {
 public:
  explicit Table(py::ssize_t steps) : steps_(steps) {}

  template <typename T>
  T* column(const char* name, std::vector<py::ssize_t> tail = {}) {
    tail.insert(tail.begin(), steps_);
    py::array_t<T> array(tail);
    table_[name] = array;
    return array.mutable_data();
  }
  /// The first `rows` rows of every column.
  py::dict take(std::ptrdiff_t rows) {
    if (rows < steps_)
      for (auto item : table_) table_[item.first] = item.second[py::slice(0, rows, 1)];
    return std::move(table_);
  }

 private:
  py::ssize_t steps_;
  py::dict table_;
};

/// The columns of Simulation::record(), filled step by step without the interpreter.
class Records {
 public:
  Records(const Simulation& simulation, const Indices& probes, py::ssize_t steps)
      : simulation_(simulation), probes_(probes), table_(steps) {
    for (const char* name : {"time", "kinetic_energy", "elastic_energy", "load_work", "viscous_loss",
                             "numerical_loss", "ledger_error"})
      always_.push_back(table_.column<double>(name));
    iterations_ = table_.column<std::int32_t>("iterations");
    inverted_ = table_.column<std::int32_t>("inverted_tissue");
    probe_values_ = table_.column<double>("probes", {probes.size(), 3});
    if (simulation.airflow()) {
      sections_ = simulation.airflow()->sections().count();
      for (const char* name : {"flow", "minimum_area", "coupling_residual"})
        flow_.push_back(table_.column<double>(name));
      for (const char* name :
           {"separation", "flow_stopped", "coupling_sweeps", "coupling_frozen", "coupling_converged"})
        flow_counts_.push_back(table_.column<std::int32_t>(name));
      area_ = table_.column<double>("section_area", {sections_});
      pressure_ = table_.column<double>("section_pressure", {sections_});
      right_ = table_.column<double>("coronal_right", {sections_, 3});
      left_ = table_.column<double>("coronal_left", {sections_, 3});
    }
    if (simulation.collision()) {
      force_first_ = table_.column<double>("contact_force_first", {3});
      force_second_ = table_.column<double>("contact_force_second", {3});
      for (const char* name :
           {"contact_area", "contact_length", "largest_contact_pressure", "deepest_gap", "overlap_volume",
            "edge_overlap_volume", "largest_multiplier", "contact_work", "contact_gap_error", "contact_slide"})
        contact_.push_back(table_.column<double>(name));
      for (const char* name : {"contact_rows", "contact_passes", "contact_converged"})
        contact_counts_.push_back(table_.column<std::int32_t>(name));
      if (simulation.scene().contact->friction) friction_loss_ = table_.column<double>("friction_loss");
    }
  }

  void add(std::ptrdiff_t k) {
    const StepRecord& record = simulation_.record();
    const Ledger& ledger = simulation_.state().ledger;
    put(always_, k,
        {record.time, ledger.kinetic, ledger.elastic, ledger.load_work, ledger.viscous_loss, ledger.numerical_loss,
         ledger.error()});
    iterations_[k] = record.iterations;
    inverted_[k] = record.inverted_tissue;
    for (std::ptrdiff_t p = 0; p < probes_.size(); ++p)
      Eigen::Map<Vector3>(probe_values_ + 3 * (k * probes_.size() + p)) =
          simulation_.state().displacement.segment<3>(3 * probes_[p]);
    if (record.flow) add_flow(k, *record.flow);
    if (record.contact) add_contact(k, *record.contact, ledger.contact_work);
  }

  py::dict take(std::ptrdiff_t rows) { return table_.take(rows); }

 private:
  template <typename T>
  static void put(const std::vector<T*>& columns, std::ptrdiff_t k, std::initializer_list<T> values) {
    std::size_t c = 0;
    for (const T value : values) columns[c++][k] = value;
  }

  void add_flow(std::ptrdiff_t k, const FlowRecord& flow) {
    put(flow_, k, {flow.state.flow, flow.state.area.minCoeff(), flow.residual});
    put<std::int32_t>(flow_counts_, k,
                      {flow.state.separation, flow.state.stopped, flow.sweeps, flow.frozen, flow.converged});
    Eigen::Map<Vector>(area_ + k * sections_, sections_) = flow.state.area;
    Eigen::Map<Vector>(pressure_ + k * sections_, sections_) = flow.state.pressure;
    const Sections& sections = simulation_.airflow()->sections();
    const Points x = simulation_.positions();
    for (std::ptrdiff_t s = 0; s < sections_; ++s) {
      Eigen::Map<Vector3>(right_ + 3 * (k * sections_ + s)) = sections.right[static_cast<std::size_t>(s)].at(x);
      Eigen::Map<Vector3>(left_ + 3 * (k * sections_ + s)) = sections.left[static_cast<std::size_t>(s)].at(x);
    }
  }

  void add_contact(std::ptrdiff_t k, const ContactRecord& contact, double work) {
    Eigen::Map<Vector3>(force_first_ + 3 * k) = contact.force_first;
    Eigen::Map<Vector3>(force_second_ + 3 * k) = contact.force_second;
    put(contact_, k,
        {contact.area, contact.length, contact.peak_pressure, contact.deepest_gap, contact.overlap_volume,
         contact.edge_overlap_volume, contact.largest_multiplier, work, contact.gap_error, contact.slide});
    put<std::int32_t>(contact_counts_, k, {contact.rows, contact.passes, contact.converged});
    if (friction_loss_) friction_loss_[k] = contact.friction_loss;
  }

  const Simulation& simulation_;
  const Indices& probes_;
  Table table_;
  py::ssize_t sections_ = 0;
  std::vector<double*> always_, flow_, contact_;
  std::vector<std::int32_t*> flow_counts_, contact_counts_;
  std::int32_t *iterations_ = nullptr, *inverted_ = nullptr;
  double *probe_values_ = nullptr, *area_ = nullptr, *pressure_ = nullptr, *right_ = nullptr, *left_ = nullptr,
         *force_first_ = nullptr, *force_second_ = nullptr, *friction_loss_ = nullptr;
};

}  // namespace

py::dict state_to_dict(const State& state) {
  py::dict dict;
  dict["step"] = state.step;
  for_vectors(state, [&](const char* name, const Vector& v) { dict[name] = give(Vector(v)); });
  dict["closed"] = py::array_t<std::int32_t>(static_cast<py::ssize_t>(state.closed.size()), state.closed.data());
  dict["closed_force"] = give(Vector(state.closed_force));
  dict["depth"] = state.depth;
  dict["flow_stopped"] = state.flow_stopped;
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
  for (const py::handle key : entry("closed")) state.closed.push_back(key.cast<std::int32_t>());
  state.closed_force = entry("closed_force").cast<Vector>();
  state.depth = entry("depth").cast<double>();
  state.flow_stopped = entry("flow_stopped").cast<bool>();
  for_energies(state.ledger, [&](const char* name, double& value) { value = entry(name).cast<double>(); });
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

py::dict SteppedSimulation::advance(int steps) {
  if (steps < 0) throw InvalidInput("Simulation", "steps", steps, "", ">= 0");
  Records records(simulation_, probes_, steps);
  std::ptrdiff_t done = 0;
  std::optional<SolveFailed> failure;
  {
    const py::gil_scoped_release released;
    try {
      for (; done < steps; ++done) {
        simulation_.advance();
        records.add(done);
      }
    } catch (const SolveFailed& caught) {
      failure = caught;
    }
  }
  if (!failure) return records.take(done);
  const py::object kind = py::module_::import("plica.errors").attr("StepFailed");
  const py::object error = kind(failure->what(), records.take(done));
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
  info["matrix_bytes"] = simulation_.step_matrix().values().size() * sizeof(double);
  if (simulation_.airflow()) info["sections"] = simulation_.airflow()->sections().count();
  if (simulation_.collision()) {
    info["airway_tetrahedra"] = simulation_.collision()->detector().airway().tets.rows();
    info["contact_solver"] = name_of(*simulation_.contact_solver());
  }
  return info;
}

py::dict SteppedSimulation::times() const {
  const StepTimes t = simulation_.times();
  py::dict times;
  times["residual"] = t.residual;
  times["load"] = t.load;
  times["solve"] = t.solve;
  times["detection"] = t.detection;
  times["contact"] = t.contact;
  times["ledger"] = t.ledger;
  times["record"] = t.record;
  return times;
}

const Sections& SteppedSimulation::sections() const {
  if (!simulation_.airflow()) throw InvalidInput("Simulation: there is no airflow in this scene, so no sections.");
  return simulation_.airflow()->sections();
}

}  // namespace plica::python

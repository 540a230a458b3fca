#include "plica/dynamics/waveforms.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <type_traits>
#include <utility>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"

namespace plica {

namespace {

using Of = Waveform::Of;
using Per = Waveform::Per;

/// The argument that a reading function, or pointer to a member, takes.
template <typename Read, typename... Sources>
struct SourceOf;
template <typename Read, typename First, typename... Rest>
struct SourceOf<Read, First, Rest...> : std::conditional_t<std::is_invocable_v<Read, const First&>,
                                                           std::common_type<First>, SourceOf<Read, Rest...>> {};
template <typename Read>
struct SourceOf<Read> {};  // reads none of them: does not compile

const StepRecord& source(const StepTaken& step, const StepRecord*) { return step.simulation().record(); }
const Ledger& source(const StepTaken& step, const Ledger*) { return step.simulation().state().ledger; }
const FlowRecord& source(const StepTaken& step, const FlowRecord*) { return *step.simulation().record().flow; }
const ContactRecord& source(const StepTaken& step, const ContactRecord*) {
  return *step.simulation().record().contact;
}
const StepTaken& source(const StepTaken& step, const StepTaken*) { return step; }

/// One waveform. The type of what `read` takes says which part of a scene it is of, the type of what it returns
/// says the rest: whole number, number, vector (Vector3), one number (Vector) or vector (Points) a section.
template <typename Read>
Waveform wave(const char* name, const char* unit, const char* meaning, Read read) {
  using Source = typename SourceOf<Read, StepTaken, StepRecord, Ledger, FlowRecord, ContactRecord>::type;
  using Value = std::decay_t<std::invoke_result_t<Read, const Source&>>;
  Waveform waveform;
  waveform.name = name;
  waveform.unit = unit;
  waveform.meaning = meaning;
  if (std::is_same_v<Source, FlowRecord>) waveform.of = Of::airflow;
  if (std::is_same_v<Source, ContactRecord>) waveform.of = Of::contact;
  if constexpr (std::is_arithmetic_v<Value>) {
    waveform.whole = std::is_integral_v<Value>;
    waveform.read = [read](const StepTaken& step, double* out) {
      *out = static_cast<double>(std::invoke(read, source(step, static_cast<const Source*>(nullptr))));
    };
  } else {
    if (Value::SizeAtCompileTime != 3) waveform.per = Per::section;
    if (Value::SizeAtCompileTime == 3 || Value::ColsAtCompileTime == 3) waveform.components = 3;
    waveform.read = [read](const StepTaken& step, double* out) {
      const auto& value = std::invoke(read, source(step, static_cast<const Source*>(nullptr)));
      std::copy_n(value.data(), value.size(), out);
    };
  }
  return waveform;
}

Waveform only(Of of, Waveform waveform) {
  waveform.of = of;
  return waveform;
}

/// The sum of a work of both tubes, J.
template <typename Read>
Waveform of_tubes(const char* name, const char* meaning, Read read) {
  return only(Of::tubes, wave(name, "J", meaning, [read](const StepTaken& step) {
                const AirColumn::Memory& air = step.simulation().state().air;
                return read(air.trachea_work) + read(air.tract_work);
              }));
}

Waveform since_start(Waveform waveform) {
  waveform.since_start = true;
  return waveform;
}

Waveform per_probe(Waveform waveform, const char* shown) {
  waveform.per = Per::probe;
  waveform.shown = shown;
  return waveform;
}

Waveform count_per_layer(Waveform waveform) {
  waveform.per = Per::layer;
  waveform.whole = true;
  return waveform;
}

Points probe_displacements(const StepTaken& step) { return step.simulation().displacement_of(step.probes()); }

std::vector<Waveform> make_waveforms() {
  return {
      wave("time", "s", "End of the step, t_{n+1}.", &StepRecord::time),
      wave("iterations", "1",
           "Of the linear solver, over all solves of the step; with Cholesky, solves with its factor.",
           &StepRecord::iterations),
      wave("kinetic_energy", "J", "Of the tissue.", &Ledger::kinetic),
      wave("elastic_energy", "J", "Of the tissue.", &Ledger::elastic),
      since_start(wave("load_work", "J", "Work of airflow, loads and gravity since t = 0.", &Ledger::load_work)),
      since_start(
          wave("viscous_loss", "J", "Energy the tissue's viscosity took since t = 0.", &Ledger::viscous_loss)),
      since_start(
          wave("numerical_loss", "J", "Energy the time scheme took since t = 0.", &Ledger::numerical_loss)),
      since_start(
          only(Of::finite_strain,
               wave("nonlinear_loss", "J",
                    "At finite strain, what the time scheme took since t = 0 by summing a force that is not "
                    "linear in the displacement.",
                    &Ledger::nonlinear_loss))),
      only(Of::finite_strain,
           wave("force_evaluations", "1", "At finite strain, how often the step found the tissue's force anew.",
                &StepRecord::force_evaluations)),
      wave("energy_balance_error", "J", "What is missing in the balance of the energies, works and losses.",
           &Ledger::error),
      wave("inverted_tissue", "1",
           "Tissue cells inside out or folded over; with any, stresses there mean nothing.",
           &StepRecord::inverted_tissue),
      count_per_layer(wave("inverted_by_layer", "1",
                           "The same in each layer of the tissue, in the order of its names, (steps, layers).",
                           &StepRecord::inverted_by_layer)),
      wave("strain_999", "1",
           "Largest principal strain's magnitude, of the small strain (at finite strain, of Green and "
           "Lagrange's); 0.1 % "
           "of the tissue's volume has more.",
           [](const StepRecord& r) { return r.strains.strain; }),
      wave("strain_largest", "1", "The same where it is largest.",
           [](const StepRecord& r) { return r.strains.largest; }),
      wave("strain_cell", "1", "The cell where it is largest.",
           [](const StepRecord& r) { return static_cast<int>(r.strains.cell); }),
      only(Of::linear_tissue,
           wave("strain_neglected", "1",
                "Strain that linear tissue leaves out, half the square of the displacement gradient; 0.1 % of the "
                "volume has more.",
                [](const StepRecord& r) { return r.strains.neglected; })),
      per_probe(
          wave("probes", "m", "Displacement of each probe's node, (steps, probes, 3).", &probe_displacements),
          "um"),

      wave("flow", "m^3/s", "Volume flow through the glottis.", [](const FlowRecord& r) { return r.state.flow; }),
      only(Of::changing_pressure,
           wave("subglottal_pressure", "Pa",
                "Below the glottis; of a scene in which it changes by itself or has a trachea.",
                [](const FlowRecord& r) { return r.state.subglottal_pressure; })),
      only(Of::trachea,
           wave("supply_rise", "1",
                "What drives the air behind the trachea, over what the scene gives, which it reaches.",
                [](const StepTaken& s) {
                  return s.simulation().air_column()->supply_rise(s.simulation().state().air);
                })),
      only(Of::tract, wave("supraglottal_pressure", "Pa", "Above the glottis, where the vocal tract begins.",
                           [](const FlowRecord& r) { return r.state.supraglottal_pressure; })),
      only(Of::tubes, wave("flow_below", "m^3/s",
                           "Out of the air below the glottis: the flow and what the folds there make room for.",
                           [](const FlowRecord& r) { return r.state.flow_below; })),
      only(Of::tubes, wave("flow_above", "m^3/s",
                           "Into the air above the glottis: the flow less what the folds there make room for.",
                           [](const FlowRecord& r) { return r.state.flow_above; })),
      only(Of::tract, wave("lip_flow", "m^3/s", "Out of the far end of the vocal tract.",
                           [](const StepTaken& s) {
                             return s.simulation().air_column()->lip_flow(s.simulation().state().air);
                           })),
      wave("minimum_area", "m^2", "Least section area: the glottal area.",
           [](const FlowRecord& r) { return r.state.area.minCoeff(); }),
      wave("separation", "1", "First section of the free jet, from 0; with Bernoulli's flow that of least area.",
           [](const FlowRecord& r) { return r.state.separation; }),
      wave("flow_stopped", "1", "1 where contact stops the flow, as in the thesis's alone.",
           [](const FlowRecord& r) { return r.state.stopped; }),
      wave("coupling_sweeps", "1", "Evaluations of the airflow in the step.", &FlowRecord::sweeps),
      wave("coupling_residual", "1",
           "Largest pressure change of the last sweep, in subglottal pressures; without sweeps, what another "
           "would change.",
           &FlowRecord::residual),
      wave("coupling_frozen", "1",
           "1 where section of separation and stop of the flow, going to and fro, were held for the last sweeps.",
           &FlowRecord::frozen),
      wave("coupling_converged", "1", "0 where the sweeps ended above the tolerance.", &FlowRecord::converged),
      wave("air_power", "W",
           "Pressure difference along the glottis times flow; subglottal pressure without a tract.",
           [](const FlowRecord& r) { return r.state.supplied_power; }),
      wave("air_viscous_loss", "W", "What friction at the walls takes of it; the rest leaves with the jet.",
           [](const FlowRecord& r) { return r.state.viscous_power; }),
      only(Of::inertance,
           wave("air_inertial_power", "W", "What accelerates the air between the sections, of the air power.",
                [](const FlowRecord& r) { return r.state.inertial_power; })),
      since_start(only(Of::airflow,
                       wave("flow_work", "J", "Work of the airflow on the tissue since t = 0, part of load_work.",
                            &Ledger::flow_work))),
      since_start(
          only(Of::airflow, wave("air_supplied_energy", "J",
                                 "Air power since t = 0: pressure difference along the glottis times volume.",
                                 &Ledger::air_supplied_energy))),
      since_start(
          only(Of::airflow, wave("air_viscous_energy", "J", "What friction at the walls took of it since t = 0.",
                                 &Ledger::air_viscous_energy))),
      since_start(only(Of::inertance, wave("air_inertial_energy", "J", "What accelerated the air since t = 0.",
                                           &Ledger::air_inertial_energy))),
      only(Of::tubes, wave("tube_energy", "J", "Of sound and walls in trachea and vocal tract.",
                           [](const StepTaken& s) {
                             return s.simulation().air_column()->tube_energy(s.simulation().state().air);
                           })),
      since_start(of_tubes("supply_energy", "What the supply behind the trachea has given since t = 0.",
                           [](const LineWork& work) { return work.source; })),
      since_start(of_tubes("tube_outflow_energy",
                           "What the tubes have given to the glottis since t = 0: to its flow and to the folds.",
                           [](const LineWork& work) { return -work.port; })),
      since_start(
          of_tubes("tube_loss",
                   "What friction, yielding walls and the resistance of ends that reflect have taken since t = 0.",
                   [](const LineWork& work) { return work.lost; })),
      since_start(of_tubes("radiated_energy", "What has left as sound at open lips since t = 0.",
                           [](const LineWork& work) { return work.radiated; })),
      wave("section_area", "m^2", "Of each section of the airway, upward, (steps, sections).",
           [](const FlowRecord& r) -> const Vector& { return r.state.area; }),
      wave("section_pressure", "Pa", "In each section, (steps, sections).",
           [](const FlowRecord& r) -> const Vector& { return r.state.pressure; }),
      only(Of::airflow,
           wave("coronal_right", "m", "Point of the right fold in the mid-coronal plane at each section.",
                [](const StepTaken& s) { return s.simulation().coronal(Side::right); })),
      only(Of::airflow,
           wave("coronal_left", "m", "Point of the left fold in the mid-coronal plane at each section.",
                [](const StepTaken& s) { return s.simulation().coronal(Side::left); })),

      wave("contact_force_first", "N", "Sum of the contact forces on the first surface, (steps, 3).",
           &ContactRecord::force_first),
      wave("contact_force_second", "N", "Sum of the contact forces on the second surface, (steps, 3).",
           &ContactRecord::force_second),
      wave("contact_rows", "1",
           "Closed contact constraints: nodes, or means over faces, that touch the facing surface.",
           &ContactRecord::rows),
      wave("contact_passes", "1", "How often the step found anew which nodes touch the facing surface.",
           &ContactRecord::passes),
      wave("contact_gap_error", "m", "Largest gap error left at the end of the step.", &ContactRecord::gap_error),
      wave("contact_slide", "1",
           "How far closed nodes have slid along the other surface of a matched airway, at most, in mean edges.",
           &ContactRecord::slide),
      wave("contact_converged", "1", "0 where passes or augmentations left a gap error above the tolerance.",
           &ContactRecord::converged),
      wave("contact_facing", "1",
           "1 where passes did not settle, or led one surface through the other, and nodes were held apart from "
           "those that they face at rest instead.",
           &ContactRecord::facing),
      wave("contact_area", "m^2", "Of the loaded nodes (by over 1e-3 of the largest force), mean of both sides.",
           &ContactRecord::area),
      wave("contact_length", "m",
           "Anteroposterior, of the deformed fold; a loaded node stands for half the way to its neighbours.",
           &ContactRecord::length),
      wave("largest_contact_pressure", "Pa",
           "Largest nodal pressure of the step: a node's force over its area, friction left out.",
           &ContactRecord::peak_pressure),
      wave("deepest_gap", "m", "Worst gap at a node; negative is overlap.", &ContactRecord::deepest_gap),
      wave("overlap_volume", "m^3",
           "Of inverted air tetrahedra with a node inside; little worth after sliding in a matched airway.",
           &ContactRecord::overlap_volume),
      wave("edge_overlap_volume", "m^3",
           "Of inverted air tetrahedra between crossed edges, where no node meets the facing surface; likewise.",
           &ContactRecord::edge_overlap_volume),
      wave("largest_multiplier", "N",
           "Largest pull of a contact force at a node; contact can only push, so that > 0 is an error.",
           &ContactRecord::largest_multiplier),
      since_start(only(Of::contact,
                       wave("contact_work", "J", "Work of the contact forces since t = 0, friction's included.",
                            &Ledger::contact_work))),
      only(Of::friction,
           wave("friction_loss", "J", "Minus the work of friction in the step.", &ContactRecord::friction_loss)),
  };
}

const Waveform& known(const std::string& name) {
  for (const Waveform& waveform : waveforms())
    if (waveform.name == name) return waveform;
  throw InvalidInput("Recorder: \"" + name + "\" is no waveform; plica::waveforms() lists them.");
}

}  // namespace

bool Waveform::exists_in(const Scene& scene) const {
  switch (of) {
    case Of::airflow:
      return scene.airflow.has_value();
    case Of::changing_pressure:
      return scene.airflow &&
             (scene.airflow->flow.rise > 0 || scene.airflow->flow.course || scene.airflow->tubes.trachea);
    case Of::inertance:
      return scene.airflow && scene.airflow->flow.has_inertance();
    case Of::tubes:
      return scene.airflow && scene.airflow->tubes.any();
    case Of::trachea:
      return scene.airflow && scene.airflow->tubes.trachea;
    case Of::tract:
      return scene.airflow && scene.airflow->tubes.tract;
    case Of::contact:
      return scene.contact.has_value();
    case Of::friction:
      return scene.contact && scene.contact->friction;
    case Of::linear_tissue:
      return !scene.strain;
    case Of::finite_strain:
      return scene.strain.has_value();
    case Of::scene:
      break;
  }
  return true;
}

const std::vector<Waveform>& waveforms() {
  static const std::vector<Waveform> all = make_waveforms();
  return all;
}

std::vector<std::string> waveforms_of(const Scene& scene) {
  std::vector<std::string> names;
  for (const Waveform& waveform : waveforms())
    if (waveform.exists_in(scene)) names.push_back(waveform.name);
  return names;
}

std::ptrdiff_t Recorder::Column::size() const {
  return std::accumulate(shape.begin(), shape.end(), std::ptrdiff_t{1}, std::multiplies<>());
}

Recorder::Recorder(const Simulation& simulation, const std::vector<std::string>& names, Indices probes)
    : simulation_(simulation), probes_(std::move(probes)) {
  const std::ptrdiff_t nodes = simulation.scene().mesh.node_count();
  for (const std::int32_t node : probes_)
    if (node < 0 || node >= nodes)
      throw InvalidInput("Recorder", "probe node", node, "", "in [0, " + std::to_string(nodes) + ")");
  for (const std::string& name : names) {
    const Waveform& waveform = known(name);
    if (!waveform.exists_in(simulation.scene()))
      throw InvalidInput(
          "Recorder: \"" + name +
          "\" is a waveform of airflow, its rise, inertance, trachea or tract, of contact or friction, of finite "
          "strain or of linear tissue; the scene must have that part.");
    std::vector<std::ptrdiff_t> shape;
    if (waveform.per == Per::section) shape.push_back(simulation.airflow()->sections().count());
    if (waveform.per == Per::probe) shape.push_back(probes_.size());
    if (waveform.per == Per::layer)
      shape.push_back(static_cast<std::ptrdiff_t>(simulation.scene().mesh.layer_names.size()));
    if (waveform.components > 1) shape.push_back(waveform.components);
    columns_.push_back({waveform, std::move(shape), 0, {}});
  }
}

void Recorder::reserve(std::ptrdiff_t steps) {
  require_at_least("Recorder", "the steps to reserve", steps, 0);
  for (Column& column : columns_)
    column.values.reserve(column.values.size() + static_cast<std::size_t>(steps * column.size()));
}

void Recorder::add() {
  const StepRecord& record = simulation_.record();
  if (simulation_.state().step == 0 || record.flow.has_value() != simulation_.scene().airflow.has_value() ||
      record.contact.has_value() != simulation_.scene().contact.has_value())
    throw InvalidInput(
        "Recorder: the simulation has no last step; must have advanced since it was made or restored.");
  const StepTaken step(simulation_, probes_);
  for (Column& column : columns_) {
    const std::size_t before = column.values.size();
    ++column.steps;
    column.values.resize(before + static_cast<std::size_t>(column.size()));
    column.waveform.read(step, column.values.data() + before);
  }
}

const Recorder::Column& Recorder::column(const std::string& name) const {
  for (const Column& column : columns_)
    if (column.waveform.name == name) return column;
  throw InvalidInput("Recorder: \"" + name + "\" is not recorded.");
}

std::vector<Recorder::Column> Recorder::take() {
  std::vector<Column> empty;
  for (const Column& column : columns_) empty.push_back({column.waveform, column.shape, 0, {}});
  return std::exchange(columns_, std::move(empty));
}

}  // namespace plica

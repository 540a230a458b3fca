#pragma once
#include <functional>

#include "plica/dynamics/simulation.hpp"

namespace plica {

/// A step that was taken, as waveforms read it.
class StepTaken {
 public:
  StepTaken(const Simulation& simulation, const Indices& probes) : simulation_(simulation), probes_(probes) {}
  const Simulation& simulation() const { return simulation_; }
  const Indices& probes() const { return probes_; }  // node numbers

 private:
  const Simulation& simulation_;
  const Indices& probes_;
};

/// What can be recorded of every step: one number, or a fixed number of them.
struct Waveform {
  /// What a scene must have for it to exist.
  enum class Of {
    scene,
    airflow,
    changing_pressure,
    inertance,
    tubes,
    trachea,
    tract,
    contact,
    friction,
    linear_tissue,
    finite_strain
  };
  /// What there is one of, or three: each step, each section of the airflow, each probe, each layer of the tissue.
  enum class Per { step, section, probe, layer };

  std::string name, unit, meaning;  // SI, "1" for a pure number; a sentence
  Of of = Of::scene;
  Per per = Per::step;
  int components = 1;        // 3: along x, y, z
  bool whole = false;        // whole numbers, 0 and 1 for no and yes
  bool since_start = false;  // adds up from t = 0 on
  std::string shown;         // the unit that people read, where it is not the usual one of `unit`
  /// Writes what the step has of it: row after row, each of `components`.
  std::function<void(const StepTaken&, double*)> read;

  bool exists_in(const Scene& scene) const;
};

/// Every waveform there is, each defined in waveforms.cpp and nowhere else.
const std::vector<Waveform>& waveforms();
/// The names of those that the scene has.
std::vector<std::string> waveforms_of(const Scene& scene);

/// Records waveforms step by step:
///
///   Recorder recorder(simulation, {"flow", "minimum_area"});
///   while (simulation.time() < 0.1) simulation.advance(), recorder.add();
///   const std::vector<double>& flow = recorder.column("flow").values;
///
/// It refers to the simulation, which must outlive it.
class Recorder {
 public:
  struct Column {
    Waveform waveform;
    std::vector<std::ptrdiff_t> shape;  // of one step: {}, {3}, {sections}, {sections, 3}, {probes, 3}, {layers}
    std::ptrdiff_t steps = 0;
    std::vector<double> values;   // step after step
    std::ptrdiff_t size() const;  // numbers a step
  };

  /// probes: the nodes whose displacement is recorded. Throws InvalidInput where a name is not known or not the
  /// scene's.
  Recorder(const Simulation& simulation, const std::vector<std::string>& names, Indices probes = {});

  void reserve(std::ptrdiff_t steps);
  /// Adds the simulation's last step. Throws InvalidInput where it has none: it is new, or was restored.
  void add();
  const std::vector<Column>& columns() const { return columns_; }
  /// Throws InvalidInput where it is not recorded.
  const Column& column(const std::string& name) const;
  /// What was recorded since the beginning or the last call.
  std::vector<Column> take();

 private:
  const Simulation& simulation_;
  Indices probes_;
  std::vector<Column> columns_;
};

}  // namespace plica

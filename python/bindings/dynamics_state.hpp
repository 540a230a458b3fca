#pragma once
#include <pybind11/eigen.h>

#include "arrays.hpp"
#include "plica/dynamics/waveforms.hpp"

namespace plica::python {

/// Every entry of a State as an array, and back; the names are those of the fields.
py::dict state_to_dict(const State& state);
State state_from_dict(const py::dict& dict);

/// A simulation that hands out what its steps were like as arrays with the step as leading axis.
class SteppedSimulation {
 public:
  SteppedSimulation(Scene scene, const Simulation::Options& options, Indices probes)
      : simulation_(std::move(scene), options),
        recorder_(simulation_, waveforms_of(simulation_.scene()), std::move(probes)) {}

  Simulation& simulation() { return simulation_; }
  const Simulation& simulation() const { return simulation_; }
  /// Takes `steps` steps and returns their records by name. Where one fails, throws plica.errors.StepFailed, which
  /// has the records of those before it.
  py::dict advance(int steps);
  py::dict info() const;
  py::dict times() const;
  /// Throws InvalidInput without airflow.
  const Sections& sections() const;

 private:
  Simulation simulation_;
  Recorder recorder_;
};

}  // namespace plica::python

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
      : simulation_(std::move(scene), options), probes_(std::move(probes)) {
    Recorder(simulation_, {}, probes_);  // throws where a probe is no node
  }

  Simulation& simulation() { return simulation_; }
  const Simulation& simulation() const { return simulation_; }
  /// Takes `steps` steps and returns these waveforms of them by name, all that the scene has where none are named.
  /// Where a step fails, throws plica.errors.StepFailed, which has those of the steps before it.
  py::dict advance(int steps, const std::optional<std::vector<std::string>>& waveforms);
  py::dict info() const;
  /// A matrix of the motion, of all nodes.
  template <typename Matrix>
  SparseMatrix whole(const Matrix& matrix) const {
    const MirrorImages* images = simulation_.images();
    return images ? images->unfolded(matrix.to_sparse()) : matrix.to_sparse();
  }
  /// (copies, p) nodes of each copy of a symmetric scene's part; none without symmetry.
  std::optional<py::array_t<std::int32_t>> images() const;
  py::dict times() const;
  /// Throws InvalidInput without airflow.
  const Sections& sections() const;

 private:
  Simulation simulation_;
  Indices probes_;
};

}  // namespace plica::python

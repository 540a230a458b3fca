#include <pybind11/complex.h>

#include "arrays.hpp"
#include "engine.hpp"
#include "options.hpp"
#include "plica/airflow/transmission_line.hpp"

using namespace plica;
using namespace plica::python;

namespace {

using Complexes = py::array_t<std::complex<double>, py::array::c_style | py::array::forcecast>;

/// TransmissionLine::response at each s: impedances and transfers.
std::pair<Complexes, Complexes> tube_response(const Tube& tube, double density, double sound_speed,
                                              double viscosity, const Complexes& s) {
  const TransmissionLine line(tube, {density, sound_speed, viscosity}, "Tube");
  Complexes impedance(s.size()), transfer(s.size());
  for (py::ssize_t i = 0; i < s.size(); ++i) {
    const TransmissionLine::Response found = line.response(s.data()[i]);
    impedance.mutable_data()[i] = found.impedance;
    transfer.mutable_data()[i] = found.transfer;
  }
  return {impedance, transfer};
}

}  // namespace

void bind_airflow(py::module_& engine) {
  options<YieldingWall>("YieldingWall", option("mass", &YieldingWall::mass),
                        option("resistance", &YieldingWall::resistance),
                        option("stiffness", &YieldingWall::stiffness))
      .bind(engine, {}, py::kw_only());
  options<Radiation>("Radiation").bind(engine);
  options<PressureSupply>("PressureSupply", option("reflection", &PressureSupply::reflection),
                          option("volume", &PressureSupply::volume))
      .bind(engine, {}, py::kw_only());
  options<FlowSupply>("FlowSupply", option("flow", &FlowSupply::flow), option("volume", &FlowSupply::volume))
      .bind(engine, {}, py::kw_only());
  options<Tube>("Tube", required("length", &Tube::length), required("area", &Tube::area),
                option("end", &Tube::end), option("wall", &Tube::wall),
                option("friction_frequency", &Tube::friction_frequency))
      .bind(engine, {}, py::kw_only());
  engine.def("tube_response", &tube_response, py::arg("tube"), py::kw_only(), py::arg("density"),
             py::arg("sound_speed"), py::arg("viscosity"), py::arg("s"));
}

#include "arrays.hpp"
#include "engine.hpp"
#include "options.hpp"
#include "plica/airflow/tube.hpp"

using namespace plica;
using namespace plica::python;

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
}

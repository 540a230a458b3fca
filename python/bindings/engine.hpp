#pragma once
#include <pybind11/pybind11.h>

// Each file of this folder adds the classes and functions of one module to plica._engine.
void bind_mesh(pybind11::module_& engine);
void bind_tissue(pybind11::module_& engine);
void bind_imaging(pybind11::module_& engine);
void bind_sight(pybind11::module_& engine);
void bind_estimation(pybind11::module_& engine);
void bind_estimation_sweep(pybind11::module_& engine);
void bind_airflow(pybind11::module_& engine);
void bind_contact(pybind11::module_& engine);
void bind_dynamics(pybind11::module_& engine);
void bind_statics(pybind11::module_& engine);
void bind_glottal_flow(pybind11::module_& engine);

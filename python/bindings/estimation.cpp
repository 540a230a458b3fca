#include "arrays.hpp"
#include "engine.hpp"

void bind_estimation(pybind11::module_& /*engine*/) {}

#include "engine.hpp"

#include <pybind11/stl.h>

#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "plica/core/versions.hpp"
#include "plica/solve/factorization.hpp"

namespace py = pybind11;

namespace {

std::string compiler() {
#if defined(__clang__)
  return "Clang " + std::to_string(__clang_major__) + "." + std::to_string(__clang_minor__) + "." +
         std::to_string(__clang_patchlevel__);
#elif defined(__GNUC__)
  return "GCC " __VERSION__;
#else
  return "unknown";
#endif
}

std::string standard_library() {
#if defined(_LIBCPP_VERSION)
  return "libc++ " + std::to_string(_LIBCPP_VERSION / 10000);
#elif defined(_GLIBCXX_RELEASE)
  return "libstdc++ " + std::to_string(_GLIBCXX_RELEASE);
#else
  return "unknown";
#endif
}

/// The version of its kernels that this processor takes (core/versions.hpp).
std::string kernels() {
  if (plica::takes_largest()) return "AVX-512 with FMA";
  if (plica::takes_fused()) return "AVX2 with FMA";
  return plica::takes_wide() ? "AVX2" : "any processor";
}

/// What this build contains; parts that are not in it are listed as absent.
py::dict build_info() {
  py::list present, absent;
  for (const char* name : {"core", "mesh", "solve", "tissue", "airflow", "imaging", "estimation"}) {
    present.append(name);
  }
#ifdef PLICA_WITH_CONTACT
  present.append("contact");
#else
  absent.append("contact");
#endif
#ifdef PLICA_WITH_DYNAMICS
  present.append("dynamics");
#else
  absent.append("dynamics");
#endif
#ifdef PLICA_WITH_MESHING
  present.append("meshing");
#else
  absent.append("meshing");
#endif
  py::dict info;
  info["version"] = PLICA_VERSION;
  info["compiler"] = compiler();
  info["standard_library"] = standard_library();
  info["backend"] = plica::Factorization::backend();
  info["kernels"] = kernels();
#ifdef PLICA_IS_GPL
  info["gpl"] = true;
#else
  info["gpl"] = false;
#endif
  info["modules"] = present;
  info["absent"] = absent;
  return info;
}

}  // namespace

PYBIND11_MODULE(_engine, engine) {
  engine.doc() = "The compiled engine of plica; private, see the package plica.";
  py::register_exception<plica::InvalidInput>(engine, "InvalidInput", PyExc_ValueError);
  py::register_exception<plica::SolveFailed>(engine, "SolveFailed", PyExc_RuntimeError);

  engine.def("build_info", &build_info);
  engine.def("set_threads", &plica::set_threads, py::arg("count"));
  engine.def("threads", &plica::threads);

  bind_mesh(engine);
  bind_tissue(engine);
  bind_airflow(engine);
  bind_imaging(engine);
  bind_sight(engine);
  bind_estimation(engine);
  bind_estimation_sweep(engine);
#ifdef PLICA_WITH_CONTACT
  bind_contact(engine);
#endif
#ifdef PLICA_WITH_DYNAMICS
  bind_dynamics(engine);
  bind_statics(engine);
  bind_glottal_flow(engine);
#endif
}

#include <pybind11/functional.h>

#include "arrays.hpp"
#include "dynamics_scene.hpp"
#include "dynamics_state.hpp"
#include "engine.hpp"
#include "options.hpp"
#include "plica/dynamics/last_basis.hpp"
#include "plica/dynamics/rigid_motion.hpp"
#include "plica/dynamics/simulation.hpp"

namespace plica::python {

template <>
struct Names<decltype(Airflow::Options::load_shape)> {
  static Named<decltype(Airflow::Options::load_shape)> all() {
    return {{"reference", Airflow::ReferenceShape{}}, {"current", Airflow::CurrentShape{}}};
  }
};
template <>
struct Names<ContactSolver> {
  static Named<ContactSolver> all() {
    Named<ContactSolver> named;
    for (const ContactSolver& solver :
         {ContactSolver(Automatic{}), ContactSolver(Condensed{}), ContactSolver(Saddle{}), ContactSolver(Gmres{})})
      named.emplace_back(name_of(solver), solver);
    return named;
  }
};
template <>
struct Names<decltype(Multipliers::position)> {
  static Named<decltype(Multipliers::position)> all() {
    return {{"end_of_step", EndOfStep{}}, {"weighted", Weighted{}}};
  }
};
template <>
struct Names<SurfaceMass> {
  static Named<SurfaceMass> all() {
    return {{"kept", SurfaceMass::kept}, {"redistributed", SurfaceMass::redistributed}};
  }
};

template <>
struct Names<Symmetry> {
  static Named<Symmetry> all() { return {{"half", Symmetry::half}, {"quarter", Symmetry::quarter}}; }
};

template <>
struct Shown<std::optional<Friction>> {
  using Given = std::optional<double>;
  static std::optional<Friction> take(Given coefficient, const char*, const char*) {
    return coefficient ? std::optional<Friction>({*coefficient}) : std::nullopt;
  }
  static Given show(const std::optional<Friction>& friction) {
    return friction ? Given(friction->coefficient) : std::nullopt;
  }
  static Given initial(const std::optional<Friction>& friction) { return show(friction); }
};

/// Given as what it is, with its faces; seen by its name.
template <>
struct Shown<FaceMethod> {
  using Given = FaceMethod;
  static FaceMethod take(FaceMethod given, const char*, const char*) { return given; }
  static std::string show(const FaceMethod& faces) {
    return std::holds_alternative<Mortar>(faces) ? "mortar" : "nodes";
  }
  static FaceMethod initial(const FaceMethod& faces) { return faces; }
};

/// The faces of a surface.
template <>
struct Shown<Faces> {
  using Given = py::array;
  static Faces take(const py::array& given, const char* owner, const char* option) {
    return to_rows(given, {3, 6}, owner, option);
  }
};

}  // namespace plica::python

using namespace plica;
using namespace plica::python;

namespace {

using Released = py::gil_scoped_release;

void bind_options(py::module_& engine) {
  options<Newmark>("Newmark", option("beta", &Newmark::beta), option("gamma", &Newmark::gamma))
      .bind(engine, {}, py::kw_only());
  options<HilberHughesTaylor>("HilberHughesTaylor", option("alpha", &HilberHughesTaylor::alpha))
      .bind(engine, {}, py::kw_only());
  options<CentralDifferences>("CentralDifferences").bind(engine);
  engine.def(
      "scheme_coefficients",
      [](const TimeScheme& scheme) {
        const SchemeCoefficients found = scheme_coefficients(scheme);
        return py::make_tuple(found.alpha, found.beta, found.gamma);
      },
      py::arg("scheme"));

  using Linear = LinearSolver;
  options<Linear::Automatic>("Automatic", option("memory", &Linear::Automatic::memory))
      .bind(engine, {}, py::kw_only());
  options<Linear::Cholesky>("Cholesky", option("max_iterations", &Linear::Cholesky::max_iterations))
      .bind(engine, {}, py::kw_only());
  options<Linear::ConjugateGradients>("ConjugateGradients",
                                      option("max_iterations", &Linear::ConjugateGradients::max_iterations))
      .bind(engine, {}, py::kw_only());

  options<Lagged>("Lagged").bind(engine);
  options<Extrapolated>("Extrapolated").bind(engine);
  options<Iterated>("Iterated", option("tolerance", &Iterated::tolerance),
                    option("max_sweeps", &Iterated::max_sweeps), option("freeze_after", &Iterated::freeze_after))
      .bind(engine, {}, py::kw_only());
  options<ViscousSlit>("ViscousSlit", option("separation_ratio", &ViscousSlit::separation_ratio),
                       option("air_viscosity", &ViscousSlit::air_viscosity),
                       option("least_gap", &ViscousSlit::least_gap), option("inertance", &ViscousSlit::inertance))
      .bind(engine, {}, py::kw_only());
  options<Bernoulli>("Bernoulli", option("zero_flow_fraction", &Bernoulli::zero_flow_fraction))
      .bind(engine, {}, py::kw_only());
  options<CutSections>("Cut", option("sections", &CutSections::sections)).bind(engine, {}, py::kw_only());
  options<EllipticSections>("Elliptic").bind(engine);
  options<PressureCourse>("Course", required("time", &PressureCourse::time),
                          required("pressure", &PressureCourse::pressure))
      .bind(
          engine, [](const PressureCourse& course) { course.validate(); }, py::kw_only());
  using Flow = Airflow::Options;
  const auto flow = &AirflowPart::flow;
  const auto tubes = &AirflowPart::tubes;
  options<AirflowPart>("Airflow", option("surface", &AirflowPart::surface),
                       option("subglottal_pressure", flow, &Flow::subglottal_pressure),
                       option("rise", flow, &Flow::rise), option("course", flow, &Flow::course),
                       option("air_density", flow, &Flow::air_density), option("model", flow, &Flow::model),
                       option("area", flow, &Flow::area), option("load_shape", flow, &Flow::load_shape),
                       option("coupling", &AirflowPart::coupling), option("trachea", tubes, &Tubes::trachea),
                       option("tract", tubes, &Tubes::tract), option("sound_speed", tubes, &Tubes::sound_speed))
      .bind(
          engine,
          [](const AirflowPart& part) {
            part.flow.validate();
            part.tubes.validate();
          },
          py::kw_only());

  options<Load>("Load", required("surface", &Load::surface), required("traction", &Load::traction),
                option("frequency", &Load::frequency), option("phase", &Load::phase))
      .bind(engine, {}, py::kw_only());
}

void bind_enforcement(py::module_& engine) {
  options<Multipliers>("Multipliers", option("solver", &Multipliers::solver),
                       option("position", &Multipliers::position))
      .bind(engine, {}, py::kw_only());
  options<Penalty>("Penalty", option("stiffness", &Penalty::stiffness)).bind(engine, {}, py::kw_only());
  options<VolumePenalty>("VolumePenalty", option("kappa", &VolumePenalty::kappa)).bind(engine, {}, py::kw_only());
  options<Augmented>("Augmented", option("stiffness", &Augmented::stiffness), option("growth", &Augmented::growth),
                     option("reduction", &Augmented::reduction),
                     option("max_augmentations", &Augmented::max_augmentations))
      .bind(engine, {}, py::kw_only());
  options<Nitsche>("Nitsche", option("factor", &Nitsche::factor)).bind(engine, {}, py::kw_only());

  options<AtNodes>("AtNodes").bind(engine);
  options<Mortar>("Mortar", taken("first", &Mortar::first), taken("second", &Mortar::second)).bind(engine);
  const auto limits = &ContactPart::options;
  options<ContactPart>(
      "Contact", taken("airway", &ContactPart::airway), required("enforcement", &ContactPart::enforcement),
      option("tolerance", limits, &Collision::Options::tolerance),
      option("max_passes", limits, &Collision::Options::max_passes), option("friction", &ContactPart::friction),
      option("surface_mass", &ContactPart::surface_mass), option("faces", &ContactPart::faces))
      .bind(engine, {}, py::kw_only());
}

void bind_reduction(py::module_& engine) {
  py::class_<LastBasis, std::shared_ptr<LastBasis>>(engine, "LastBasis").def(py::init<>());
  options<Reduction>("Reduction", taken("basis", &Reduction::basis),
                     option("watch_every", &Reduction::watch_every),
                     option("damping_ratio", &Reduction::damping_ratio))
      .bind(engine, {}, py::kw_only());
}

void bind_finite_strain(py::module_& engine) {
  options<FiniteStrain>("FiniteStrain", option("tolerance", &FiniteStrain::tolerance),
                        option("max_iterations", &FiniteStrain::max_iterations))
      .bind(
          engine, [](const FiniteStrain& strain) { strain.validate(); }, py::kw_only());
}

void bind_waveforms(py::module_& engine) {
  py::class_<Waveform>(engine, "Waveform")
      .def_readonly("name", &Waveform::name)
      .def_readonly("unit", &Waveform::unit)
      .def_readonly("meaning", &Waveform::meaning)
      .def_readonly("shown", &Waveform::shown)
      .def_readonly("since_start", &Waveform::since_start)
      .def_property_readonly("per", [](const Waveform& waveform) {
        if (waveform.per == Waveform::Per::step) return "step";
        if (waveform.per == Waveform::Per::layer) return "layer";
        return waveform.per == Waveform::Per::section ? "section" : "probe";
      });
  engine.def("waveforms", &waveforms);
}

/// One for each body that can move without strain: its lowest node, and whether none of its unknowns is held.
std::vector<std::pair<std::int32_t, bool>> free_bodies(const TetMesh& mesh, const Held& fixed) {
  std::vector<std::pair<std::int32_t, bool>> found;
  for (const RigidMotion& motion : rigid_motions(mesh, to_supports(fixed, mesh.node_count())))
    found.emplace_back(motion.body, motion.unheld);
  return found;
}

std::unique_ptr<SteppedSimulation> make_simulation(
    const TetMesh& mesh, std::vector<Material> materials, std::vector<std::string> names,
    const py::array& cell_material, const Held& fixed, const TimeScheme& scheme, double step, double tolerance,
    const LinearSolver::Method& solver, bool lumped_mass, std::optional<AirflowPart> airflow,
    std::optional<ContactPart> contact, std::vector<Load> loads, std::optional<Vec3> gravity,
    std::optional<RealArray> displacement, std::optional<RealArray> velocity, std::optional<py::array> probes,
    std::optional<Reduction> reduction, std::optional<std::shared_ptr<LastBasis>> last_basis,
    const std::optional<std::string>& symmetry, const std::optional<FiniteStrain>& strain) {
  Scene scene =
      make_scene(mesh, std::move(materials), std::move(names), cell_material, fixed, std::move(loads), gravity);
  scene.airflow = std::move(airflow);
  scene.contact = std::move(contact);
  if (displacement) scene.displacement = to_points(*displacement, "Simulation", "displacement");
  if (velocity) scene.velocity = to_points(*velocity, "Simulation", "velocity");
  scene.reduction = std::move(reduction);
  if (scene.reduction) scene.reduction->last = std::move(last_basis).value_or(nullptr);
  if (symmetry) scene.symmetry = Shown<Symmetry>::take(*symmetry, "Simulation", "symmetry");
  scene.strain = strain;
  Simulation::Options options;
  options.scheme = scheme;
  options.step = step;
  options.solver = {tolerance, solver};
  options.mass = lumped_mass ? Simulation::Mass::lumped : Simulation::Mass::consistent;
  Indices probe_nodes = probes ? to_indices(*probes, "Simulation", "probes") : Indices(0);
  const Released released;
  return std::make_unique<SteppedSimulation>(std::move(scene), options, std::move(probe_nodes));
}

Points matrix_of(const Vector& nodal) { return as_points(nodal); }

}  // namespace

void bind_dynamics(py::module_& engine) {
  py::class_<SteppedSimulation> simulation(engine, "Simulation");
  bind_waveforms(engine);
  bind_options(engine);
  bind_enforcement(engine);
  bind_reduction(engine);
  bind_finite_strain(engine);
  engine.def("free_bodies", &free_bodies, py::arg("mesh"), py::arg("fixed"));
  const Simulation::Options options;
  simulation
      .def(py::init(&make_simulation), py::arg("mesh"), py::arg("materials"), py::arg("material_names"),
           py::arg("cell_material"), py::arg("fixed"), py::kw_only(), py::arg("scheme"),
           py::arg("step") = options.step, py::arg("solver_tolerance") = options.solver.tolerance,
           py::arg("solver") = options.solver.method, py::arg("lumped_mass") = false,
           py::arg("airflow") = py::none(), py::arg("contact") = py::none(), py::arg("loads") = py::list(),
           py::arg("gravity") = py::none(), py::arg("displacement") = py::none(), py::arg("velocity") = py::none(),
           py::arg("probes") = py::none(), py::arg("reduction") = py::none(), py::arg("last_basis") = py::none(),
           py::arg("symmetry") = py::none(), py::arg("strain") = py::none())
      .def("advance", &SteppedSimulation::advance, py::arg("steps"), py::arg("waveforms") = py::none())
      .def("state", [](const SteppedSimulation& self) { return state_to_dict(self.simulation().state()); })
      .def(
          "restore",
          [](SteppedSimulation& self, const py::dict& state) {
            State given = state_from_dict(state);
            const Released released;
            self.simulation().restore(std::move(given));
          },
          py::arg("state"))
      .def(
          "renewed",
          [](const SteppedSimulation& self, const py::dict& state) {
            State found = state_from_dict(state);
            {
              const Released released;
              found = self.simulation().renewed(std::move(found));
            }
            return state_to_dict(found);
          },
          py::arg("state"))
      .def(
          "set_external_force",
          [](SteppedSimulation& self, const RealArray& force) {
            self.simulation().set_external_force(as_vector(to_points(force, "Simulation", "external force")));
          },
          py::arg("force"))
      .def(
          "largest_step", [](const SteppedSimulation& self) { return self.simulation().largest_step(); },
          py::call_guard<Released>())
      .def("info", &SteppedSimulation::info)
      .def("times", &SteppedSimulation::times)
      .def_property_readonly("time", [](const SteppedSimulation& self) { return self.simulation().time(); })
      .def_property_readonly("step_count",
                             [](const SteppedSimulation& self) { return self.simulation().state().step; })
      .def_property_readonly(
          "displacement",
          [](const SteppedSimulation& self) { return give(matrix_of(self.simulation().displacement())); })
      .def_property_readonly(
          "velocity", [](const SteppedSimulation& self) { return give(matrix_of(self.simulation().velocity())); })
      .def_property_readonly(
          "acceleration",
          [](const SteppedSimulation& self) { return give(matrix_of(self.simulation().acceleration())); })
      .def_property_readonly(
          "contact_force",
          [](const SteppedSimulation& self) { return give(matrix_of(self.simulation().contact_force())); })
      .def_property_readonly(
          "contact_pressure",
          [](const SteppedSimulation& self) { return give(self.simulation().contact_pressure()); })
      .def_property_readonly(
          "mass", [](const SteppedSimulation& self) { return give_csr(self.whole(self.simulation().mass())); })
      .def_property_readonly(
          "stiffness",
          [](const SteppedSimulation& self) { return give_csr(self.whole(self.simulation().stiffness())); })
      .def_property_readonly("viscosity",
                             [](const SteppedSimulation& self) -> std::optional<py::tuple> {
                               const auto& viscosity = self.simulation().viscosity();
                               if (!viscosity) return std::nullopt;
                               return give_csr(self.whole(*viscosity));
                             })
      .def_property_readonly("images", &SteppedSimulation::images)
      .def_property_readonly("section_height",
                             [](const SteppedSimulation& self) { return give(self.sections().height); })
      .def_property_readonly("section_major",
                             [](const SteppedSimulation& self) { return give(self.sections().major); });
}

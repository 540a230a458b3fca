#include "arrays.hpp"
#include "dynamics_state.hpp"
#include "engine.hpp"
#include "plica/dynamics/simulation.hpp"
#include "plica/dynamics/statics.hpp"

using namespace plica;
using namespace plica::python;

namespace {

using Released = py::gil_scoped_release;

Airflow::Options flow_options(double pressure, double density, double fraction, const std::string& area,
                              const std::string& load_shape) {
  Airflow::Options options;
  options.subglottal_pressure = pressure;
  options.air_density = density;
  options.zero_flow_fraction = fraction;
  if (area == "cut")
    options.area = Airflow::Cut{};
  else if (area != "elliptic")
    throw InvalidInput("Airflow: area = \"" + area + "\"; must be \"elliptic\" or \"cut\".");
  if (load_shape == "current")
    options.load_shape = Airflow::CurrentShape{};
  else if (load_shape != "reference")
    throw InvalidInput("Airflow: load_shape = \"" + load_shape + "\"; must be \"reference\" or \"current\".");
  options.validate();
  return options;
}

ContactSolver contact_solver(const std::string& name) {
  for (const ContactSolver& solver :
       {ContactSolver(Automatic{}), ContactSolver(Condensed{}), ContactSolver(Saddle{}), ContactSolver(Gmres{})})
    if (name == name_of(solver)) return solver;
  throw InvalidInput("Multipliers: solver = \"" + name +
                     "\"; must be \"auto\", \"condensed\", \"saddle\" or \"gmres\".");
}

Multipliers multipliers(const std::string& solver, const std::string& position) {
  Multipliers enforcement{contact_solver(solver), EndOfStep{}};
  if (position == "weighted")
    enforcement.position = Weighted{};
  else if (position != "end_of_step")
    throw InvalidInput("Multipliers: position = \"" + position + "\"; must be \"end_of_step\" or \"weighted\".");
  return enforcement;
}

const char* name_of(SurfaceMass mass) { return mass == SurfaceMass::kept ? "kept" : "redistributed"; }

SurfaceMass to_surface_mass(const std::string& name) {
  for (const SurfaceMass mass : {SurfaceMass::kept, SurfaceMass::redistributed})
    if (name == name_of(mass)) return mass;
  throw InvalidInput("Contact: surface_mass = \"" + name + "\"; must be \"kept\" or \"redistributed\".");
}

void bind_options(py::module_& engine) {
  const Newmark newmark;
  py::class_<Newmark>(engine, "Newmark")
      .def(py::init([](double beta, double gamma) {
             return Newmark{beta, gamma};
           }),
           py::kw_only(), py::arg("beta") = newmark.beta, py::arg("gamma") = newmark.gamma)
      .def_readonly("beta", &Newmark::beta)
      .def_readonly("gamma", &Newmark::gamma);
  const HilberHughesTaylor hht;
  py::class_<HilberHughesTaylor>(engine, "HilberHughesTaylor")
      .def(py::init([](double alpha) { return HilberHughesTaylor{alpha}; }), py::kw_only(),
           py::arg("alpha") = hht.alpha)
      .def_readonly("alpha", &HilberHughesTaylor::alpha);

  py::class_<Lagged>(engine, "Lagged").def(py::init<>());
  py::class_<Extrapolated>(engine, "Extrapolated").def(py::init<>());
  const Iterated iterated;
  py::class_<Iterated>(engine, "Iterated")
      .def(py::init([](double tolerance, int max_sweeps, int freeze_after) {
             return Iterated{tolerance, max_sweeps, freeze_after};
           }),
           py::kw_only(), py::arg("tolerance") = iterated.tolerance, py::arg("max_sweeps") = iterated.max_sweeps,
           py::arg("freeze_after") = iterated.freeze_after)
      .def_readonly("tolerance", &Iterated::tolerance)
      .def_readonly("max_sweeps", &Iterated::max_sweeps)
      .def_readonly("freeze_after", &Iterated::freeze_after);

  const AirflowPart part;
  py::class_<AirflowPart>(engine, "Airflow")
      .def(py::init([](std::string surface, double pressure, double density, double fraction,
                       const std::string& area, const std::string& load_shape, Coupling coupling) {
             return AirflowPart{std::move(surface), flow_options(pressure, density, fraction, area, load_shape),
                                coupling};
           }),
           py::kw_only(), py::arg("surface") = part.surface,
           py::arg("subglottal_pressure") = part.flow.subglottal_pressure,
           py::arg("air_density") = part.flow.air_density,
           py::arg("zero_flow_fraction") = part.flow.zero_flow_fraction, py::arg("area") = "elliptic",
           py::arg("load_shape") = "reference", py::arg_v("coupling", part.coupling, "..."))
      .def_readonly("surface", &AirflowPart::surface)
      .def_property_readonly(
          "load_shape",
          [](const AirflowPart& p) {
            return std::holds_alternative<Airflow::CurrentShape>(p.flow.load_shape) ? "current" : "reference";
          })
      .def_readonly("coupling", &AirflowPart::coupling)
      .def_property_readonly("subglottal_pressure",
                             [](const AirflowPart& a) { return a.flow.subglottal_pressure; })
      .def_property_readonly("air_density", [](const AirflowPart& a) { return a.flow.air_density; })
      .def_property_readonly("zero_flow_fraction", [](const AirflowPart& a) { return a.flow.zero_flow_fraction; })
      .def_property_readonly("area", [](const AirflowPart& a) {
        return std::holds_alternative<Airflow::Cut>(a.flow.area) ? "cut" : "elliptic";
      });

  const Load load;
  py::class_<Load>(engine, "Load")
      .def(
          py::init([](std::string surface, const std::array<double, 3>& traction, double frequency, double phase) {
            return Load{std::move(surface), Vector3(traction[0], traction[1], traction[2]), frequency, phase};
          }),
          py::kw_only(), py::arg("surface"), py::arg("traction"), py::arg("frequency") = load.frequency,
          py::arg("phase") = load.phase);
}

void bind_enforcement(py::module_& engine) {
  py::class_<Multipliers>(engine, "Multipliers")
      .def(py::init(&multipliers), py::kw_only(), py::arg("solver") = name_of(Multipliers{}.solver),
           py::arg("position") = "end_of_step")
      .def_property_readonly("solver", [](const Multipliers& m) { return name_of(m.solver); })
      .def_property_readonly("position", [](const Multipliers& m) {
        return std::holds_alternative<Weighted>(m.position) ? "weighted" : "end_of_step";
      });
  const Penalty penalty;
  py::class_<Penalty>(engine, "Penalty")
      .def(py::init([](double stiffness) { return Penalty{stiffness}; }), py::kw_only(),
           py::arg("stiffness") = penalty.stiffness)
      .def_readonly("stiffness", &Penalty::stiffness);
  const VolumePenalty volume;
  py::class_<VolumePenalty>(engine, "VolumePenalty")
      .def(py::init([](double kappa) { return VolumePenalty{kappa}; }), py::kw_only(),
           py::arg("kappa") = volume.kappa)
      .def_readonly("kappa", &VolumePenalty::kappa);
  const Augmented augmented;
  py::class_<Augmented>(engine, "Augmented")
      .def(py::init([](double stiffness, double growth, double reduction, int max_augmentations) {
             return Augmented{stiffness, growth, reduction, max_augmentations};
           }),
           py::kw_only(), py::arg("stiffness") = augmented.stiffness, py::arg("growth") = augmented.growth,
           py::arg("reduction") = augmented.reduction, py::arg("max_augmentations") = augmented.max_augmentations)
      .def_readonly("stiffness", &Augmented::stiffness)
      .def_readonly("growth", &Augmented::growth)
      .def_readonly("reduction", &Augmented::reduction)
      .def_readonly("max_augmentations", &Augmented::max_augmentations);
  const Nitsche nitsche;
  py::class_<Nitsche>(engine, "Nitsche")
      .def(py::init([](double factor) { return Nitsche{factor}; }), py::kw_only(),
           py::arg("factor") = nitsche.factor)
      .def_readonly("factor", &Nitsche::factor);
  py::class_<AtNodes>(engine, "AtNodes").def(py::init<>());
  py::class_<Mortar>(engine, "Mortar")
      .def(py::init([](const py::array& first, const py::array& second) {
             return Mortar{to_rows(first, {3, 6}, "Mortar", "first"), to_rows(second, {3, 6}, "Mortar", "second")};
           }),
           py::arg("first"), py::arg("second"));
  const Collision::Options options;
  py::class_<ContactPart>(engine, "Contact")
      .def(py::init([](const Airway& airway, const Enforcement& enforcement, double tolerance, int max_passes,
                       std::optional<double> friction, const std::string& surface_mass, const FaceMethod& faces) {
             ContactPart part{airway, enforcement, {tolerance, max_passes}, {}, to_surface_mass(surface_mass),
                              faces};
             if (friction) part.friction = Friction{*friction};
             return part;
           }),
           py::kw_only(), py::arg("airway"), py::arg("enforcement"), py::arg("tolerance") = options.tolerance,
           py::arg("max_passes") = options.max_passes, py::arg("friction") = py::none(),
           py::arg("surface_mass") = name_of(ContactPart{}.surface_mass),
           py::arg_v("faces", ContactPart{}.faces, "..."))
      .def_property_readonly(
          "faces",
          [](const ContactPart& c) { return std::holds_alternative<Mortar>(c.faces) ? "mortar" : "nodes"; })
      .def_property_readonly("friction",
                             [](const ContactPart& c) -> std::optional<double> {
                               if (!c.friction) return std::nullopt;
                               return c.friction->coefficient;
                             })
      .def_property_readonly("tolerance", [](const ContactPart& c) { return c.options.tolerance; })
      .def_property_readonly("max_passes", [](const ContactPart& c) { return c.options.max_passes; })
      .def_property_readonly("surface_mass", [](const ContactPart& c) { return name_of(c.surface_mass); });
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
        return waveform.per == Waveform::Per::section ? "section" : "probe";
      });
  engine.def("waveforms", &waveforms);
}

using Held = py::array_t<bool, py::array::c_style | py::array::forcecast>;
using Vec3 = std::array<double, 3>;

Supports to_supports(const Held& fixed, std::ptrdiff_t nodes) {
  if (fixed.ndim() != 2 || fixed.shape(0) != nodes || fixed.shape(1) != 3)
    wrong_shape("Scene", "fixed", fixed, "(" + std::to_string(nodes) + ", 3)");
  Supports supports(nodes);
  for (std::int32_t i = 0; i < nodes; ++i)
    for (int c = 0; c < 3; ++c)
      if (fixed.at(i, c)) supports.fix(i, c);
  return supports;
}

Scene make_scene(const TetMesh& mesh, std::vector<Material> materials, std::vector<std::string> names,
                 const py::array& cell_material, const Held& fixed, std::vector<Load> loads,
                 const std::optional<Vec3>& gravity) {
  Scene scene{mesh,
              {std::move(materials), std::move(names), to_indices(cell_material, "Scene", "cell_material")},
              to_supports(fixed, mesh.node_count()),
              std::nullopt,
              std::nullopt,
              std::move(loads),
              std::nullopt,
              std::nullopt,
              std::nullopt};
  if (gravity) scene.gravity = Vector3((*gravity)[0], (*gravity)[1], (*gravity)[2]);
  return scene;
}

py::array_t<double> equilibrium_of(const TetMesh& mesh, std::vector<Material> materials,
                                   std::vector<std::string> names, const py::array& cell_material,
                                   const Held& fixed, std::vector<Load> loads,
                                   const std::optional<Vec3>& gravity) {
  const Scene scene =
      make_scene(mesh, std::move(materials), std::move(names), cell_material, fixed, std::move(loads), gravity);
  return give([&] {
    const Released released;
    return equilibrium(scene);
  }());
}

struct AtRest {
  Points displacement, contact_force;
  Vector contact_pressure;
  int rows, passes, pivots;
};

AtRest contact_equilibrium_of(const TetMesh& mesh, std::vector<Material> materials, std::vector<std::string> names,
                              const py::array& cell_material, const Held& fixed, const ContactPart& contact,
                              std::vector<Load> loads, const std::optional<Vec3>& gravity,
                              const std::optional<RealArray>& displacement) {
  Scene scene =
      make_scene(mesh, std::move(materials), std::move(names), cell_material, fixed, std::move(loads), gravity);
  scene.contact = contact;
  if (displacement) scene.displacement = to_points(*displacement, "contact_equilibrium", "displacement");
  const Released released;
  ContactEquilibrium rest = contact_equilibrium(scene);
  return {std::move(rest.displacement),
          as_points(rest.contact_force),
          std::move(rest.contact_pressure),
          static_cast<int>(rest.closed.size()),
          rest.passes,
          rest.pivots};
}

std::unique_ptr<SteppedSimulation> make_simulation(
    const TetMesh& mesh, std::vector<Material> materials, std::vector<std::string> names,
    const py::array& cell_material, const Held& fixed, const TimeScheme& scheme, double step, double tolerance,
    int max_iterations, bool lumped_mass, std::optional<AirflowPart> airflow, std::optional<ContactPart> contact,
    std::vector<Load> loads, std::optional<Vec3> gravity, std::optional<RealArray> displacement,
    std::optional<RealArray> velocity, std::optional<py::array> probes) {
  Scene scene =
      make_scene(mesh, std::move(materials), std::move(names), cell_material, fixed, std::move(loads), gravity);
  scene.airflow = std::move(airflow);
  scene.contact = std::move(contact);
  if (displacement) scene.displacement = to_points(*displacement, "Simulation", "displacement");
  if (velocity) scene.velocity = to_points(*velocity, "Simulation", "velocity");
  Simulation::Options options;
  options.scheme = scheme;
  options.step = step;
  options.solver.tolerance = tolerance;
  options.solver.max_iterations = max_iterations;
  options.mass = lumped_mass ? Simulation::Mass::lumped : Simulation::Mass::consistent;
  Indices probe_nodes = probes ? to_indices(*probes, "Simulation", "probes") : Indices(0);
  const Released released;
  return std::make_unique<SteppedSimulation>(std::move(scene), options, std::move(probe_nodes));
}

Points matrix_of(const Vector& nodal) { return as_points(nodal); }

}  // namespace

void bind_dynamics(py::module_& engine) {
  bind_waveforms(engine);
  bind_options(engine);
  bind_enforcement(engine);
  engine.def("equilibrium", &equilibrium_of, py::arg("mesh"), py::arg("materials"), py::arg("material_names"),
             py::arg("cell_material"), py::arg("fixed"), py::kw_only(), py::arg("loads") = py::list(),
             py::arg("gravity") = py::none());
  py::class_<AtRest>(engine, "ContactEquilibrium")
      .def_property_readonly("displacement",
                             [](py::object self) { return view(self.cast<AtRest&>().displacement, self); })
      .def_property_readonly("contact_force",
                             [](py::object self) { return view(self.cast<AtRest&>().contact_force, self); })
      .def_property_readonly("contact_pressure",
                             [](py::object self) { return view(self.cast<AtRest&>().contact_pressure, self); })
      .def_readonly("rows", &AtRest::rows)
      .def_readonly("passes", &AtRest::passes)
      .def_readonly("pivots", &AtRest::pivots);
  engine.def("contact_equilibrium", &contact_equilibrium_of, py::arg("mesh"), py::arg("materials"),
             py::arg("material_names"), py::arg("cell_material"), py::arg("fixed"), py::kw_only(),
             py::arg("contact"), py::arg("loads") = py::list(), py::arg("gravity") = py::none(),
             py::arg("displacement") = py::none());
  const Simulation::Options options;
  py::class_<SteppedSimulation>(engine, "Simulation")
      .def(py::init(&make_simulation), py::arg("mesh"), py::arg("materials"), py::arg("material_names"),
           py::arg("cell_material"), py::arg("fixed"), py::kw_only(), py::arg("scheme"),
           py::arg("step") = options.step, py::arg("solver_tolerance") = options.solver.tolerance,
           py::arg("max_iterations") = options.solver.max_iterations, py::arg("lumped_mass") = false,
           py::arg("airflow") = py::none(), py::arg("contact") = py::none(), py::arg("loads") = py::list(),
           py::arg("gravity") = py::none(), py::arg("displacement") = py::none(), py::arg("velocity") = py::none(),
           py::arg("probes") = py::none())
      .def("advance", &SteppedSimulation::advance, py::arg("steps"))
      .def("state", [](const SteppedSimulation& self) { return state_to_dict(self.simulation().state()); })
      .def(
          "restore",
          [](SteppedSimulation& self, const py::dict& state) {
            self.simulation().restore(state_from_dict(state));
          },
          py::arg("state"))
      .def(
          "set_external_force",
          [](SteppedSimulation& self, const RealArray& force) {
            self.simulation().set_external_force(as_vector(to_points(force, "Simulation", "external force")));
          },
          py::arg("force"))
      .def("info", &SteppedSimulation::info)
      .def("times", &SteppedSimulation::times)
      .def_property_readonly("time", [](const SteppedSimulation& self) { return self.simulation().time(); })
      .def_property_readonly("step_count",
                             [](const SteppedSimulation& self) { return self.simulation().state().step; })
      .def_property_readonly(
          "displacement",
          [](const SteppedSimulation& self) { return give(matrix_of(self.simulation().state().displacement)); })
      .def_property_readonly(
          "velocity",
          [](const SteppedSimulation& self) { return give(matrix_of(self.simulation().state().velocity)); })
      .def_property_readonly(
          "acceleration",
          [](const SteppedSimulation& self) { return give(matrix_of(self.simulation().state().acceleration)); })
      .def_property_readonly(
          "contact_force",
          [](const SteppedSimulation& self) { return give(matrix_of(self.simulation().state().contact_force)); })
      .def_property_readonly(
          "contact_pressure",
          [](const SteppedSimulation& self) { return give(self.simulation().contact_pressure()); })
      .def_property_readonly(
          "mass", [](const SteppedSimulation& self) { return give_csr(self.simulation().mass().to_sparse()); })
      .def_property_readonly(
          "stiffness",
          [](const SteppedSimulation& self) { return give_csr(self.simulation().stiffness().to_sparse()); })
      .def_property_readonly("viscosity",
                             [](const SteppedSimulation& self) -> std::optional<py::tuple> {
                               const auto& viscosity = self.simulation().viscosity();
                               if (!viscosity) return std::nullopt;
                               return give_csr(viscosity->to_sparse());
                             })
      .def_property_readonly("section_height",
                             [](const SteppedSimulation& self) { return give(self.sections().height); })
      .def_property_readonly("section_major",
                             [](const SteppedSimulation& self) { return give(self.sections().major); });
}

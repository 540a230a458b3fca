#include <pybind11/functional.h>

#include "arrays.hpp"
#include "dynamics_scene.hpp"
#include "dynamics_state.hpp"
#include "engine.hpp"
#include "options.hpp"
#include "plica/dynamics/posture.hpp"
#include "plica/dynamics/statics.hpp"

namespace {

using namespace plica;
using namespace plica::python;
using Released = py::gil_scoped_release;

py::array_t<double> equilibrium_of(const TetMesh& mesh, std::vector<Material> materials,
                                   std::vector<std::string> names, const py::array& cell_material,
                                   const Held& fixed, std::vector<Load> loads, const std::optional<Vec3>& gravity,
                                   bool finite_strain) {
  Scene scene =
      make_scene(mesh, std::move(materials), std::move(names), cell_material, fixed, std::move(loads), gravity);
  if (finite_strain) scene.strain = FiniteStrain{};
  return give([&] {
    const Released released;
    return equilibrium(scene);
  }());
}

/// The mesh at its posture, and how it was found.
struct StretchedMesh {
  std::shared_ptr<TetMesh> mesh;
  int parts, iterations;
};

StretchedMesh stretched_mesh(const TetMesh& mesh, std::vector<Material> materials, std::vector<std::string> names,
                             const py::array& cell_material, const Held& fixed,
                             const std::function<RealArray(double)>& held) {
  const Tissue tissue{std::move(materials), std::move(names),
                      to_indices(cell_material, "Tissue", "cell_material")};
  const Supports supports = to_supports(fixed, mesh.node_count());
  const HeldAt at = [&held](double share) {
    const py::gil_scoped_acquire acquired;
    return to_points(held(share), "stretched", "held");
  };
  const Released released;
  const Posture posture = stretched(mesh, tissue, supports, at);
  StretchedMesh found{std::make_shared<TetMesh>(mesh), posture.parts, posture.iterations};
  found.mesh->rest = mesh.points;
  found.mesh->points += posture.displacement;
  return found;
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

/// K u = f for many f, held unknowns zero.
class StaticSolver {
 public:
  explicit StaticSolver(const SteppedSimulation& of)
      : StaticSolver(of.simulation().supports(), of.simulation().stiffness()) {}
  StaticSolver(Supports supports, BlockMatrix K) : supports_(std::move(supports)), K_(std::move(K)) {
    supports_.constrain(K_);
    solver_ = LinearSolver::make(K_, {1e-10, LinearSolver::Cholesky{}});
  }
  Eigen::MatrixXd solve(Eigen::MatrixXd forces) const {
    if (forces.rows() != K_.rows())
      throw InvalidInput("StaticSolver", "rows of forces", static_cast<double>(forces.rows()), "",
                         std::to_string(K_.rows()));
    for (std::ptrdiff_t i = 0; i < forces.rows(); ++i)
      if (supports_.fixed(i)) forces.row(i).setZero();
    Eigen::MatrixXd found(forces.rows(), forces.cols()), part;
    for (std::ptrdiff_t first = 0; first < forces.cols(); first += LinearSolver::pack) {
      const std::ptrdiff_t count = std::min<std::ptrdiff_t>(LinearSolver::pack, forces.cols() - first);
      for (const Convergence& end :
           solver_->solve_many(forces.middleCols(first, count), part, solver_->tolerance()))
        if (!end.converged)
          throw SolveFailed("StaticSolver: residual = " + number_text(end.residual) + "; must be <= 1e-10.");
      found.middleCols(first, count) = part;
    }
    return found;
  }

 private:
  Supports supports_;
  BlockMatrix K_;
  std::unique_ptr<const LinearSolver> solver_;
};

/// A scene's tissue at finite strain, at rest under gravity and loads where it is displaced.
class HeldTissue {
 public:
  explicit HeldTissue(Scene scene) : scene_(std::move(scene)), statics_(scene_) {}
  Points unbalanced(const Points& displacement) const {
    return as_points(statics_.unbalanced(as_vector(displacement)));
  }
  std::unique_ptr<StaticSolver> solver(const Points& displacement) const {
    return std::make_unique<StaticSolver>(scene_.supports, statics_.slope(as_vector(displacement)));
  }

 private:
  const Scene scene_;
  const StretchedStatics statics_;
};

std::unique_ptr<HeldTissue> held_tissue(const TetMesh& mesh, std::vector<Material> materials,
                                        std::vector<std::string> names, const py::array& cell_material,
                                        const Held& fixed, std::vector<Load> loads,
                                        const std::optional<Vec3>& gravity) {
  Scene scene =
      make_scene(mesh, std::move(materials), std::move(names), cell_material, fixed, std::move(loads), gravity);
  scene.strain = FiniteStrain{};
  const Released released;
  return std::make_unique<HeldTissue>(std::move(scene));
}

}  // namespace

void bind_statics(py::module_& engine) {
  py::class_<StaticSolver>(engine, "StaticSolver")
      .def(py::init<const SteppedSimulation&>(), py::arg("simulation"), py::call_guard<Released>())
      .def("solve", &StaticSolver::solve, py::arg("forces"), py::call_guard<Released>());
  py::class_<StretchedMesh>(engine, "StretchedMesh")
      .def_readonly("mesh", &StretchedMesh::mesh)
      .def_readonly("parts", &StretchedMesh::parts)
      .def_readonly("iterations", &StretchedMesh::iterations);
  engine.def("stretched", &stretched_mesh, py::arg("mesh"), py::arg("materials"), py::arg("material_names"),
             py::arg("cell_material"), py::arg("fixed"), py::arg("held"));
  engine.def("equilibrium", &equilibrium_of, py::arg("mesh"), py::arg("materials"), py::arg("material_names"),
             py::arg("cell_material"), py::arg("fixed"), py::kw_only(), py::arg("loads") = py::list(),
             py::arg("gravity") = py::none(), py::arg("finite_strain") = false);
  py::class_<HeldTissue>(engine, "StretchedStatics")
      .def(py::init(&held_tissue), py::arg("mesh"), py::arg("materials"), py::arg("material_names"),
           py::arg("cell_material"), py::arg("fixed"), py::kw_only(), py::arg("loads") = py::list(),
           py::arg("gravity") = py::none())
      .def(
          "unbalanced",
          [](const HeldTissue& self, const RealArray& displacement) {
            const Points u = to_points(displacement, "StretchedStatics", "displacement");
            return give([&] {
              const Released released;
              return self.unbalanced(u);
            }());
          },
          py::arg("displacement"))
      .def(
          "solver",
          [](const HeldTissue& self, const RealArray& displacement) {
            const Points u = to_points(displacement, "StretchedStatics", "displacement");
            const Released released;
            return self.solver(u);
          },
          py::arg("displacement"));
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
}

#include "dynamics_state.hpp"
#include "engine.hpp"
#include "plica/airflow/flow_tangent.hpp"
#include "plica/airflow/line_system.hpp"

using namespace plica;
using namespace plica::python;

namespace {

using Released = py::gil_scoped_release;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A tube of a scene, seen from the glottis.
struct SeenTube {
  LineSystem system;
  double steady_resistance;
};

SeenTube seen(const Tube& tube, const AirflowPart& part, const char* where) {
  const TransmissionLine line(tube, gas_of(part.flow, part.tubes.sound_speed), where);
  return {line_system(line), line.steady_resistance()};
}

/// The airflow of a simulation by itself: through given areas, under given pressures at its ends.
class GlottalFlow {
 public:
  explicit GlottalFlow(const SteppedSimulation& of)
      : simulation_(of.simulation()), airflow_(of.simulation().airflow()) {
    if (airflow_ == nullptr) throw InvalidInput("GlottalFlow: airflow is missing; must be in the scene.");
  }

  Air air(double below, double above) const {
    Air air = airflow_->air(airflow_->options().rise);
    air.subglottal_pressure = below;
    air.supraglottal_pressure = above;
    return air;
  }
  Vector to_vector(const RealArray& values, const char* name) const {
    if (values.ndim() != 1) wrong_shape("GlottalFlow", name, values, "one-dimensional");
    return Eigen::Map<const Vector>(values.data(), values.size());
  }

  /// (w, n): widths of the x of nodes.
  SparseMatrix width_map() const {
    const SectionAreas& areas = airflow_->section_areas();
    std::vector<Eigen::Triplet<double>> entries;
    for (std::ptrdiff_t width = 0; width < areas.width_count(); ++width)
      for (const auto& [node, weight] : areas.terms(width))
        entries.emplace_back(static_cast<int>(width), node, weight);
    SparseMatrix map(areas.width_count(), simulation_.scene().mesh.node_count());
    map.setFromTriplets(entries.begin(), entries.end());
    return map;
  }
  Vector width_spacing() const {
    const SectionAreas& areas = airflow_->section_areas();
    Vector spacing(areas.width_count());
    for (std::ptrdiff_t width = 0; width < spacing.size(); ++width) spacing[width] = areas.spacing(width);
    return spacing;
  }
  /// (3 n, s + 2): loads of 1 Pa at each section, below the first, above the last.
  SparseMatrix load_patterns() const {
    const LoadPatterns& patterns = airflow_->load_patterns();
    const Indices& nodes = airflow_->nodes();
    const std::ptrdiff_t sections = patterns.sections.cols();
    std::vector<Eigen::Triplet<double>> entries;
    const auto add = [&](std::ptrdiff_t row, std::ptrdiff_t column, double value) {
      if (value != 0)
        entries.emplace_back(3 * nodes[row / 3] + static_cast<int>(row % 3), static_cast<int>(column), value);
    };
    for (std::ptrdiff_t row = 0; row < patterns.sections.rows(); ++row) {
      for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator at(patterns.sections, row); at; ++at)
        add(row, at.col(), at.value());
      add(row, sections, patterns.below[row]);
      add(row, sections + 1, patterns.above[row]);
    }
    SparseMatrix map(3 * static_cast<std::ptrdiff_t>(simulation_.scene().mesh.node_count()), sections + 2);
    map.setFromTriplets(entries.begin(), entries.end());
    return map;
  }
  const Airflow& airflow() const { return *airflow_; }
  /// Pa s^2/m^3, from the first to the last section; 0 without.
  double inertance(const Vector& areas) const {
    const FlowState state = airflow_->evaluate(areas, air(1.0, 0.0));
    return state.momentum.size() > 0 ? state.momentum[areas.size() - 1] / state.flow : 0.0;
  }
  std::optional<SeenTube> trachea() const { return open(part().tubes.trachea, "Trachea"); }
  std::optional<SeenTube> tract() const { return open(part().tubes.tract, "Tract"); }

 private:
  const AirflowPart& part() const { return *simulation_.scene().airflow; }
  std::optional<SeenTube> open(const std::optional<Tube>& tube, const char* where) const {
    if (!tube) return std::nullopt;
    if (std::holds_alternative<FlowSupply>(tube->end))
      throw InvalidInput(std::string("GlottalFlow: ") + where +
                         ": the far end is closed, or supplied by a flow; must be open, or held at a pressure: "
                         "equilibria and oscillations are those under a pressure.");
    return seen(*tube, part(), where);
  }

  const Simulation& simulation_;
  const Airflow* airflow_;
};

void bind_tangent(py::module_& engine) {
  const auto give_member = [](auto member) {
    return [member](py::object self) { return view(self.cast<FlowTangent&>().*member, self); };
  };
  const auto dense = [](auto member) {
    return [member](const FlowTangent& self) { return give(RowMatrix(self.*member)); };
  };
  py::class_<FlowTangent>(engine, "FlowTangent")
      .def_property_readonly("pressure",
                             [](py::object self) { return view(self.cast<FlowTangent&>().state.pressure, self); })
      .def_property_readonly("flow", [](const FlowTangent& self) { return self.state.flow; })
      .def_property_readonly("separation", [](const FlowTangent& self) { return self.state.separation; })
      .def_property_readonly("pressure_by_area", dense(&FlowTangent::pressure_by_area))
      .def_property_readonly("pressure_by_drop", give_member(&FlowTangent::pressure_by_drop))
      .def_property_readonly("flow_by_area", give_member(&FlowTangent::flow_by_area))
      .def_readonly("flow_by_drop", &FlowTangent::flow_by_drop)
      .def_property_readonly("momentum_by_area", dense(&FlowTangent::momentum_by_area))
      .def_property_readonly("pressure_by_expansion", dense(&FlowTangent::pressure_by_expansion))
      .def_property_readonly("momentum_by_drop", give_member(&FlowTangent::momentum_by_drop))
      .def_property_readonly("from_below", give_member(&FlowTangent::from_below))
      .def_readonly("kink", &FlowTangent::kink);
  py::class_<SeenTube> tube(engine, "SeenTube");
  tube.attr("longest_element") = TransmissionLine::longest_element;
  tube.attr("longest_substep") = LineStep::longest_substep;
  tube.def_property_readonly("storage",
                             [](py::object self) { return view(self.cast<SeenTube&>().system.storage, self); })
      .def_property_readonly("rates", [](const SeenTube& self) { return give(RowMatrix(self.system.rates)); })
      .def_property_readonly("outflow",
                             [](py::object self) { return view(self.cast<SeenTube&>().system.outflow, self); })
      .def_property_readonly("source",
                             [](py::object self) { return view(self.cast<SeenTube&>().system.source, self); })
      .def_readonly("steady_resistance", &SeenTube::steady_resistance);
}

}  // namespace

void bind_glottal_flow(py::module_& engine) {
  bind_tangent(engine);
  engine.def(
      "tract",
      [](const AirflowPart& airflow) {
        if (!airflow.tubes.tract) throw InvalidInput("Airflow: tract is missing; must be one of its options.");
        return seen(*airflow.tubes.tract, airflow, "Tract");
      },
      py::arg("airflow"));
  py::class_<GlottalFlow>(engine, "GlottalFlow")
      .def(py::init<const SteppedSimulation&>(), py::arg("simulation"), py::keep_alive<1, 2>())
      .def("width_map", [](const GlottalFlow& self) { return give_csr(self.width_map()); })
      .def("width_spacing", [](const GlottalFlow& self) { return give(self.width_spacing()); })
      .def("load_patterns", [](const GlottalFlow& self) { return give_csr(self.load_patterns()); })
      .def_property_readonly("height",
                             [](const GlottalFlow& self) { return give(self.airflow().sections().height); })
      .def_property_readonly(
          "reference_load",
          [](const GlottalFlow& self) {
            return std::holds_alternative<Airflow::ReferenceShape>(self.airflow().options().load_shape);
          })
      .def(
          "areas",
          [](const GlottalFlow& self, const RealArray& widths) {
            return give(self.airflow().section_areas().areas(self.to_vector(widths, "widths")));
          },
          py::arg("widths"))
      .def(
          "evaluate",
          [](const GlottalFlow& self, const RealArray& areas, double below, double above) {
            FlowState state = self.airflow().evaluate(self.to_vector(areas, "areas"), self.air(below, above));
            return py::make_tuple(give(std::move(state.pressure)), state.flow);
          },
          py::arg("areas"), py::arg("below"), py::arg("above") = 0.0)
      .def(
          "inertance",
          [](const GlottalFlow& self, const RealArray& areas) {
            return self.inertance(self.to_vector(areas, "areas"));
          },
          py::arg("areas"))
      .def(
          "tangent",
          [](const GlottalFlow& self, const RealArray& areas, double below, double above) {
            const Vector a = self.to_vector(areas, "areas");
            const Released released;
            return flow_tangent(self.airflow(), a, self.air(below, above));
          },
          py::arg("areas"), py::arg("below"), py::arg("above") = 0.0)
      .def_property_readonly("trachea", &GlottalFlow::trachea)
      .def_property_readonly("tract", &GlottalFlow::tract);
}

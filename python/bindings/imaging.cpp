#include "arrays.hpp"
#include "engine.hpp"
#include "plica/imaging/flow.hpp"
#include "plica/imaging/linearise.hpp"

using namespace plica;
using namespace plica::python;

namespace {

using Released = py::gil_scoped_release;
using FloatArray = py::array_t<float, py::array::c_style | py::array::forcecast>;

Plane to_plane(const FloatArray& array, const std::string& where, const std::string& name) {
  if (array.ndim() != 2) wrong_shape(where, name, array, "(rows, columns)");
  return Eigen::Map<const Plane>(array.data(), array.shape(0), array.shape(1));
}

/// (rows, columns, 2) as two planes: u to the right, v downwards.
Flow to_flow(const FloatArray& array, const std::string& where, const std::string& name) {
  if (array.ndim() != 3 || array.shape(2) != 2) wrong_shape(where, name, array, "(rows, columns, 2)");
  const Eigen::Map<const Eigen::Array<float, Eigen::Dynamic, 2, Eigen::RowMajor>> pairs(
      array.data(), array.shape(0) * array.shape(1), 2);
  Flow flow{Plane(array.shape(0), array.shape(1)), Plane(array.shape(0), array.shape(1))};
  flow.u.reshaped<Eigen::RowMajor>() = pairs.col(0);
  flow.v.reshaped<Eigen::RowMajor>() = pairs.col(1);
  return flow;
}

py::array_t<float> give_flow(const Flow& flow) {
  py::array_t<float> array({flow.u.rows(), flow.u.cols(), std::ptrdiff_t{2}});
  Eigen::Map<Eigen::Array<float, Eigen::Dynamic, 2, Eigen::RowMajor>> pairs(array.mutable_data(), flow.u.size(),
                                                                            2);
  pairs.col(0) = flow.u.reshaped<Eigen::RowMajor>();
  pairs.col(1) = flow.v.reshaped<Eigen::RowMajor>();
  return array;
}

void same_size(const Plane& plane, const py::array& array, const Plane& other, const std::string& where,
               const std::string& name) {
  if (plane.rows() != other.rows() || plane.cols() != other.cols() || plane.rows() < 2 || plane.cols() < 2) {
    wrong_shape(where, name, array, "of the other's size, with sides of at least 2");
  }
}

PenaltyShape to_penalty(const std::string& name, const std::string& field) {
  if (name == "lorentzian") return PenaltyShape::lorentzian;
  if (name == "charbonnier") return PenaltyShape::charbonnier;
  if (name == "quadratic") return PenaltyShape::quadratic;
  throw InvalidInput("FlowOptions: " + field + " = \"" + name +
                     "\"; must be \"lorentzian\", \"charbonnier\" or \"quadratic\".");
}

const char* name_of(PenaltyShape penalty) {
  if (penalty == PenaltyShape::charbonnier) return "charbonnier";
  return penalty == PenaltyShape::lorentzian ? "lorentzian" : "quadratic";
}

}  // namespace

void bind_imaging(py::module_& engine) {
  const FlowOptions defaults;
  py::class_<FlowOptions>(engine, "FlowOptions")
      .def(py::init([](double smoothness, double data_scale, double smooth_scale, const std::string& data_penalty,
                       const std::string& smooth_penalty, std::optional<double> gradient_noise, int stages,
                       std::optional<int> levels, double spacing, int fine_levels, double fine_spacing, int warps,
                       double largest_step, int sweeps, double relaxation) {
             const FlowOptions options{smoothness,
                                       data_scale,
                                       smooth_scale,
                                       to_penalty(data_penalty, "data_penalty"),
                                       to_penalty(smooth_penalty, "smooth_penalty"),
                                       gradient_noise,
                                       stages,
                                       levels,
                                       spacing,
                                       fine_levels,
                                       fine_spacing,
                                       warps,
                                       largest_step,
                                       sweeps,
                                       relaxation};
             options.validate();
             return options;
           }),
           py::kw_only(), py::arg("smoothness") = defaults.smoothness, py::arg("data_scale") = defaults.data_scale,
           py::arg("smooth_scale") = defaults.smooth_scale,
           py::arg("data_penalty") = name_of(defaults.data_penalty),
           py::arg("smooth_penalty") = name_of(defaults.smooth_penalty),
           py::arg("gradient_noise") = defaults.gradient_noise, py::arg("stages") = defaults.stages,
           py::arg("levels") = defaults.levels, py::arg("spacing") = defaults.spacing,
           py::arg("fine_levels") = defaults.fine_levels, py::arg("fine_spacing") = defaults.fine_spacing,
           py::arg("warps") = defaults.warps, py::arg("largest_step") = defaults.largest_step,
           py::arg("sweeps") = defaults.sweeps, py::arg("relaxation") = defaults.relaxation)
      .def_readonly("smoothness", &FlowOptions::smoothness)
      .def_readonly("data_scale", &FlowOptions::data_scale)
      .def_readonly("smooth_scale", &FlowOptions::smooth_scale)
      .def_property_readonly("data_penalty", [](const FlowOptions& o) { return name_of(o.data_penalty); })
      .def_property_readonly("smooth_penalty", [](const FlowOptions& o) { return name_of(o.smooth_penalty); })
      .def_readonly("gradient_noise", &FlowOptions::gradient_noise)
      .def_readonly("stages", &FlowOptions::stages)
      .def_readonly("levels", &FlowOptions::levels)
      .def_readonly("spacing", &FlowOptions::spacing)
      .def_readonly("fine_levels", &FlowOptions::fine_levels)
      .def_readonly("fine_spacing", &FlowOptions::fine_spacing)
      .def_readonly("warps", &FlowOptions::warps)
      .def_readonly("largest_step", &FlowOptions::largest_step)
      .def_readonly("sweeps", &FlowOptions::sweeps)
      .def_readonly("relaxation", &FlowOptions::relaxation);

  engine.def(
      "dense_flow",
      [](const FloatArray& first, const FloatArray& second, const FlowOptions& options,
         const std::optional<FloatArray>& used) {
        const std::string where = "dense_flow";
        const Plane one = to_plane(first, where, "first"), two = to_plane(second, where, "second");
        const Plane counted = used ? to_plane(*used, where, "used") : Plane();
        Flow flow;
        {
          const Released released;
          flow = dense_flow(one, two, options, counted);
        }
        return give_flow(flow);
      },
      py::arg("first"), py::arg("second"), py::arg("options"), py::arg("used") = std::nullopt);
  engine.def(
      "flow_residual",
      [](const FloatArray& first, const FloatArray& second, const FloatArray& flow) {
        const std::string where = "flow_residual";
        const Plane one = to_plane(first, where, "first"), two = to_plane(second, where, "second");
        const Flow motion = to_flow(flow, where, "flow");
        same_size(two, second, one, where, "second");
        same_size(motion.u, flow, one, where, "flow");
        Plane left;
        {
          const Released released;
          left = residual(one, two, motion.u, motion.v);
        }
        return give(std::move(left));
      },
      py::arg("first"), py::arg("second"), py::arg("flow"));
  engine.def(
      "round_trip",
      [](const FloatArray& forward, const FloatArray& backward) {
        const std::string where = "round_trip";
        const Flow there = to_flow(forward, where, "forward"), back = to_flow(backward, where, "backward");
        same_size(back.u, backward, there.u, where, "backward");
        Flow missed;
        {
          const Released released;
          missed = round_trip(there, back);
        }
        return give_flow(missed);
      },
      py::arg("forward"), py::arg("backward"));
}

#include "arrays.hpp"
#include "engine.hpp"
#include "options.hpp"
#include "plica/imaging/flow.hpp"
#include "plica/imaging/linearise.hpp"

using namespace plica::imaging;

namespace plica::python {

template <>
struct Names<PenaltyShape> {
  static Named<PenaltyShape> all() {
    return {{"lorentzian", PenaltyShape::lorentzian},
            {"charbonnier", PenaltyShape::charbonnier},
            {"quadratic", PenaltyShape::quadratic}};
  }
};

template <>
struct Names<LightChange> {
  static Named<LightChange> all() { return {{"none", LightChange::none}, {"smooth", LightChange::smooth}}; }
};

}  // namespace plica::python

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

}  // namespace

void bind_imaging(py::module_& engine) {
  options<FlowOptions>(
      "FlowOptions", option("smoothness", &FlowOptions::smoothness),
      option("data_scale", &FlowOptions::data_scale), option("smooth_scale", &FlowOptions::smooth_scale),
      option("data_penalty", &FlowOptions::data_penalty), option("smooth_penalty", &FlowOptions::smooth_penalty),
      option("gradient_noise", &FlowOptions::gradient_noise), option("light", &FlowOptions::light),
      option("stages", &FlowOptions::stages), option("levels", &FlowOptions::levels),
      option("spacing", &FlowOptions::spacing), option("fine_levels", &FlowOptions::fine_levels),
      option("fine_spacing", &FlowOptions::fine_spacing), option("warps", &FlowOptions::warps),
      option("largest_step", &FlowOptions::largest_step), option("sweeps", &FlowOptions::sweeps),
      option("relaxation", &FlowOptions::relaxation))
      .bind(engine, &FlowOptions::validate, py::kw_only());

  engine.def(
      "dense_flow",
      [](const FloatArray& first, const FloatArray& second, const FlowOptions& options,
         const std::optional<FloatArray>& used, const std::optional<FloatArray>& sides,
         const std::optional<FloatArray>& measured, const std::optional<FloatArray>& displacement,
         const std::array<double, 2>& across) {
        const std::string where = "dense_flow";
        const Plane one = to_plane(first, where, "first"), two = to_plane(second, where, "second");
        const Known known{used ? to_plane(*used, where, "used") : Plane(),
                          sides ? to_plane(*sides, where, "sides") : Plane(),
                          measured ? to_plane(*measured, where, "measured") : Plane(),
                          displacement ? to_plane(*displacement, where, "displacement") : Plane(), across};
        LitFlow flow;
        {
          const Released released;
          flow = dense_flow(one, two, options, known);
        }
        return std::make_tuple(give_flow(flow), flow.light.gain, flow.light.offset);
      },
      py::arg("first"), py::arg("second"), py::arg("options"), py::arg("used") = std::nullopt,
      py::arg("sides") = std::nullopt, py::arg("measured") = std::nullopt, py::arg("displacement") = std::nullopt,
      py::arg("across") = std::array<double, 2>{1, 0});
  engine.def(
      "light_gains",
      [](const std::array<double, 6>& gain, std::ptrdiff_t rows, std::ptrdiff_t columns) {
        return give(Light{gain, 0}.gains(rows, columns));
      },
      py::arg("gain"), py::arg("rows"), py::arg("columns"));
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

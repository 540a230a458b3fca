#include "arrays.hpp"
#include "engine.hpp"
#include "plica/contact/airway.hpp"
#ifdef PLICA_WITH_MESHING
#include "plica/meshing/triangulated_airway.hpp"
#endif

using namespace plica;
using namespace plica::python;

namespace {

Airway triangulated([[maybe_unused]] const RealArray& points, [[maybe_unused]] const py::array& first,
                    [[maybe_unused]] const py::array& second) {
#ifdef PLICA_WITH_MESHING
  const std::string where = "triangulated_airway";
  const Points x = to_points(points, where, "points");
  const Triangles a = to_rows(first, {3}, where, "first");
  const Triangles b = to_rows(second, {3}, where, "second");
  check_nodes(a, x.rows(), where, "first face");
  check_nodes(b, x.rows(), where, "second face");
  const py::gil_scoped_release released;
  return triangulated_airway(x, a, b);
#else
  throw InvalidInput(
      "triangulated_airway: this build of plica has no module meshing, which contains CGAL's triangulations under "
      "the GPL. Install one that does: PLICA_GPL=ON pip install .");
#endif
}

}  // namespace

void bind_contact(py::module_& engine) {
  py::class_<Airway>(engine, "Airway")
      .def(py::init([](const py::array& first, const py::array& second, const py::array& tets) {
             return Airway{to_rows(first, {3}, "Airway", "first"), to_rows(second, {3}, "Airway", "second"),
                           to_rows(tets, {4}, "Airway", "tets")};
           }),
           py::arg("first"), py::arg("second"), py::arg("tets"))
      .def_property_readonly("first", [](py::object self) { return view(self.cast<Airway&>().first, self); })
      .def_property_readonly("second", [](py::object self) { return view(self.cast<Airway&>().second, self); })
      .def_property_readonly("tets", [](py::object self) { return view(self.cast<Airway&>().tets, self); });

  engine.def(
      "matched_airway",
      [](const RealArray& points, const py::array& first, const py::array& second,
         const std::array<double, 3>& direction) {
        const std::string where = "matched_airway";
        const Points x = to_points(points, where, "points");
        const Triangles a = to_rows(first, {3}, where, "first");
        const Triangles b = to_rows(second, {3}, where, "second");
        check_nodes(a, x.rows(), where, "first face");
        check_nodes(b, x.rows(), where, "second face");
        const py::gil_scoped_release released;
        return matched_airway(x, a, b, Vector3(direction[0], direction[1], direction[2]));
      },
      py::arg("points"), py::arg("first"), py::arg("second"), py::arg("direction"));
  engine.def("triangulated_airway", &triangulated, py::arg("points"), py::arg("first"), py::arg("second"));
}

#include "arrays.hpp"
#include "engine.hpp"
#include "plica/imaging/face_hits.hpp"
#include "plica/imaging/raster.hpp"
#include "plica/imaging/surface_values.hpp"
#include "plica/imaging/texture.hpp"

using namespace plica;
using namespace plica::imaging;
using namespace plica::python;

namespace {

using Released = py::gil_scoped_release;
using MaskArray = py::array_t<bool, py::array::c_style | py::array::forcecast>;

Pairs to_pairs(const RealArray& array, const std::string& where, const std::string& name) {
  if (array.ndim() != 2 || array.shape(1) != 2) wrong_shape(where, name, array, "(p, 2)");
  return Eigen::Map<const Pairs>(array.data(), array.shape(0), 2);
}

Table to_table(const RealArray& array, const std::string& where, const std::string& name) {
  if (array.ndim() != 2) wrong_shape(where, name, array, "(rows, columns)");
  return Eigen::Map<const Table>(array.data(), array.shape(0), array.shape(1));
}

}  // namespace

void bind_sight(py::module_& engine) {
  engine.def(
      "rasterise_triangles",
      [](const RealArray& corners, const py::array& triangles, const MaskArray& within) {
        const std::string where = "rasterise_triangles";
        const Points points = to_points(corners, where, "corners");
        const Triangles rows = to_rows(triangles, {3}, where, "triangles");
        if (within.ndim() != 2) wrong_shape(where, "within", within, "(rows, columns)");
        const PixelMask mask = Eigen::Map<const PixelMask>(within.data(), within.shape(0), within.shape(1));
        TriangleRaster raster;
        {
          const Released released;
          raster = rasterise_triangles(points, rows, mask);
        }
        return std::make_tuple(give(std::move(raster.triangle)), give(std::move(raster.share)));
      },
      py::arg("corners"), py::arg("triangles"), py::arg("within"));
  engine.def(
      "heights_above",
      [](const RealArray& places, const RealArray& corners, const py::array& triangles, std::ptrdiff_t rows,
         std::ptrdiff_t columns) {
        const std::string where = "heights_above";
        const Pairs at = to_pairs(places, where, "places");
        const Points points = to_points(corners, where, "corners");
        const Triangles three = to_rows(triangles, {3}, where, "triangles");
        Vector found;
        {
          const Released released;
          found = heights_above(at, points, three, rows, columns);
        }
        return give(std::move(found));
      },
      py::arg("places"), py::arg("corners"), py::arg("triangles"), py::arg("rows"), py::arg("columns"));
  engine.def(
      "hits_near",
      [](const RealArray& nodes, const py::array& faces, const py::array& face, const RealArray& pixels,
         const RealArray& start) {
        const std::string where = "hits_near";
        const Points points = to_points(nodes, where, "nodes");
        const Faces rows = to_rows(faces, {3, 6}, where, "faces");
        const Indices own = to_indices(face, where, "face");
        const Pairs at = to_pairs(pixels, where, "pixels"), from = to_pairs(start, where, "start");
        FaceHits hits;
        {
          const Released released;
          hits = hits_near(points, rows, own, at, from);
        }
        return std::make_tuple(give(std::move(hits.face)), give(std::move(hits.place)));
      },
      py::arg("nodes"), py::arg("faces"), py::arg("face"), py::arg("pixels"), py::arg("start"));
  engine.def(
      "first_hits",
      [](const RealArray& nodes, const py::array& faces, const RealArray& pixels) {
        const std::string where = "first_hits";
        const Points points = to_points(nodes, where, "nodes");
        const Faces rows = to_rows(faces, {3, 6}, where, "faces");
        const Pairs at = to_pairs(pixels, where, "pixels");
        FaceHits hits;
        {
          const Released released;
          hits = first_hits(points, rows, at);
        }
        return std::make_tuple(give(std::move(hits.face)), give(std::move(hits.place)));
      },
      py::arg("nodes"), py::arg("faces"), py::arg("pixels"));
  engine.def(
      "periodic_spline",
      [](const RealArray& tile, const RealArray& places, int degree) {
        const std::string where = "periodic_spline";
        if (tile.ndim() != 3 || tile.shape(0) != tile.shape(1) || tile.shape(1) != tile.shape(2))
          wrong_shape(where, "tile", tile, "(n, n, n)");
        const Points at = to_points(places, where, "places");
        const Eigen::Map<const Vector> samples(tile.data(), tile.size());
        Vector values;
        {
          const Released released;
          values = periodic_spline(samples, tile.shape(0), at, degree);
        }
        return give(std::move(values));
      },
      py::arg("tile"), py::arg("places"), py::arg("degree"));
  engine.def(
      "interpolated",
      [](const RealArray& weights, const py::array& rows, const RealArray& values) {
        const std::string where = "interpolated";
        const Table shares = to_table(weights, where, "weights"), known = to_table(values, where, "values");
        const Faces own = to_rows(rows, {3, 6}, where, "rows");
        Table found;
        {
          const Released released;
          found = interpolated(shares, own, known);
        }
        return give(std::move(found));
      },
      py::arg("weights"), py::arg("rows"), py::arg("values"));
  engine.def(
      "corner_normals",
      [](const RealArray& corners, const py::array& triangles) {
        const std::string where = "corner_normals";
        const Points points = to_points(corners, where, "corners");
        const Triangles three = to_rows(triangles, {3}, where, "triangles");
        Points normals;
        {
          const Released released;
          normals = corner_normals(points, three);
        }
        return give(std::move(normals));
      },
      py::arg("corners"), py::arg("triangles"));
  engine.def(
      "within_hull",
      [](const RealArray& sides, const RealArray& places) {
        const std::string where = "within_hull";
        const Points lines = to_points(sides, where, "sides");
        const Pairs at = to_pairs(places, where, "places");
        Eigen::Array<bool, Eigen::Dynamic, 1> inside;
        {
          const Released released;
          inside = within_hull(lines, at);
        }
        return give(std::move(inside));
      },
      py::arg("sides"), py::arg("places"));
}

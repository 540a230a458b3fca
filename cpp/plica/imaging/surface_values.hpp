#pragma once
// Values on a surface of triangles or faces, at its corners and at what pixels show of it.
#include "plica/imaging/raster.hpp"

namespace plica::imaging {

/// (p, n) weights, and dense (k, c) values.
using Table = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// sum_n w_pn v_r(p, n), (p, c): values (k, c) at nodes, interpolated with weights (p, n) of the nodes rows (p,
/// n).
Table interpolated(const Table& weights, const Faces& rows, const Table& values);

/// The sum of the triangles' normals at each corner, weighted by area: (v, 3), outward, of any length.
Points corner_normals(const Points& corners, const Triangles& triangles);

/// Whether each place (p, 2) lies in a convex hull of sides (s, 3): a x + b y + c <= 0 inside.
Eigen::Array<bool, Eigen::Dynamic, 1> within_hull(const Points& sides, const Pairs& places);

}  // namespace plica::imaging

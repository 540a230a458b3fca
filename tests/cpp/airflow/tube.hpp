#pragma once
#include <cmath>

#include "plica/mesh/tet_mesh.hpp"

/// The wall of an airway alone: rings of `around` nodes at the given heights, half-axes minor(z) in x and `major`
/// in y, the first node turned by `turn` steps from (minor, 0). Outward, towards the axis.
template <class Minor>
plica::TetMesh tube(int around, const std::vector<double>& heights, Minor minor, double major, double turn = 0) {
  const double step = 2 * std::acos(-1.0) / around;
  const int levels = static_cast<int>(heights.size());
  plica::TetMesh mesh;
  mesh.points.resize(around * levels, 3);
  for (int k = 0; k < levels; ++k)
    for (int i = 0; i < around; ++i) {
      const double angle = (i + turn) * step;
      mesh.points.row(k * around + i) << minor(heights[k]) * std::cos(angle), major * std::sin(angle), heights[k];
    }
  plica::Faces wall(2 * around * (levels - 1), 3);
  int f = 0;
  for (int k = 0; k + 1 < levels; ++k)
    for (int i = 0; i < around; ++i) {
      const int a = k * around + i, b = k * around + (i + 1) % around, c = b + around, d = a + around;
      wall.row(f++) << a, c, b;
      wall.row(f++) << a, d, c;
    }
  mesh.surfaces["airway"] = wall;
  return mesh;
}

/// Area of the polygon inscribed in an ellipse at equal steps of its parameter.
inline double inscribed(int around, double minor, double major) {
  return around / 2.0 * std::sin(2 * std::acos(-1.0) / around) * minor * major;
}

/// The wall of a straight slit: a box open at its ends, x within +-width / 2, y within +-length / 2, z from 0 up.
inline plica::TetMesh slit(double width, double length, double height) {
  constexpr int along = 8, up = 4;  // intervals of each fold
  plica::TetMesh mesh;
  const int ring = 2 * (along + 1);
  mesh.points.resize(ring * (up + 1), 3);
  for (int k = 0; k <= up; ++k)
    for (int i = 0; i < ring; ++i) {  // the right fold from front to back, the left one back again
      const int j = i <= along ? i : ring - 1 - i;
      mesh.points.row(k * ring + i) << (i <= along ? width / 2 : -width / 2), length * (double(j) / along - 0.5),
          height * k / up;
    }
  plica::Faces wall(2 * ring * up, 3);
  int f = 0;
  for (int k = 0; k < up; ++k)
    for (int i = 0; i < ring; ++i) {
      const int a = k * ring + i, b = k * ring + (i + 1) % ring, c = b + ring, d = a + ring;
      wall.row(f++) << a, c, b;
      wall.row(f++) << a, d, c;
    }
  mesh.surfaces["airway"] = wall;
  return mesh;
}

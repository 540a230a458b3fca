#pragma once
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

/// A point that moves with the tissue: a fixed combination of at most six nodes.
struct MaterialPoint {
  std::vector<std::int32_t> nodes;
  std::vector<double> weights;
  Vector3 at(const Points& x) const;
};

/// The horizontal sections of the glottis. At section i two material points lie where the reference interface
/// crosses the mid-coronal plane at height z_i, one on each fold; where no node lies in that plane the
/// interface is cut there. The plane lies halfway between the least and the largest y of the interface.
struct Sections {
  Vector height;                     // (s) m, reference z, ascending
  Vector major;                      // (s) m, half the anteroposterior extent of the airway at that height
  Vector middle;                     // (s) m, y halfway along it
  double toward_right = 1;           // 1 where x grows from the left fold to the right one, else -1
  std::vector<MaterialPoint> right;  // (s) of the right fold
  std::vector<MaterialPoint> left;   // (s) of the left fold

  std::ptrdiff_t count() const { return height.size(); }
  /// (s) m, from the left point to the right one; negative where the folds overlap.
  Vector widths(const Points& x) const;
};

/// At the mesh's levels: at every height where the right or left mid-coronal line of `surface` has a vertex
/// (heights closer than 1e-6 of the extent are one) and both lines exist. Which line is the right fold's, the
/// sides of the mesh's cells at the lines say; without sides it is that of larger x. Throws InvalidInput where the
/// surface does not cross the plane on both sides, or has several x at one height there.
Sections level_sections(const TetMesh& mesh, const Faces& surface);

/// As many as asked for (>= 2) between the lowest and the highest height that both lines have, whatever the mesh's
/// levels: their spacing is in proportion to a / L^2 + 0.05, with the area a and the anteroposterior length L of
/// the airway at rest, so that they are dense where the glottis is narrow. The section nearest to a vertex of a
/// mid-coronal line is moved to its height: the surface has an edge there, and a throat is at an edge.
Sections graded_sections(const TetMesh& mesh, const Faces& surface, int count);

/// Area enclosed by the interface at positions x in the plane z = height (m^2), from its cut polygon;
/// counts overlap of the folds as negative; nodes in the plane are allowed. O(faces).
double cut_area(const Points& x, const Triangles& surface, double height);

/// The same for many planes at ascending heights (s), in one pass: O(faces + cuts).
Vector cut_areas(const Points& x, const Triangles& surface, const Vector& heights);

}  // namespace plica

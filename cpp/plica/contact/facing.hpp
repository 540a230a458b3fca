#pragma once
#include <array>
#include <optional>

#include "plica/contact/surface.hpp"
#include "plica/mesh/face.hpp"

namespace plica {

using FaceNodes = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 6>;  // m, a column a node

/// A side of the contact with its three- or six-node faces: flat triangle t belongs to face t / triangles a face.
struct FacedSide {
  const ContactSurface& flat;
  Faces faces;

  int split() const { return triangles_of_face(faces.cols()); }
  std::int32_t face_of(std::int32_t triangle) const { return triangle / split(); }
  FaceNodes nodes(std::int32_t face, const Points& x) const {
    FaceNodes nodes(3, faces.cols());
    for (Eigen::Index k = 0; k < faces.cols(); ++k) nodes.col(k) = x.row(faces(face, k));
    return nodes;
  }
  /// Of a flat triangle.
  std::array<Vector3, 3> corners(std::int32_t triangle, const Points& x) const {
    const auto t = flat.triangles().row(triangle);
    return {x.row(t[0]), x.row(t[1]), x.row(t[2])};
  }
  /// Where a flat triangle lies in its face, (r, s).
  const ParameterTriangle& in_face(std::int32_t triangle) const {
    return parameter_triangle(faces.cols(), triangle % split());
  }
  /// Which of the three corners of a face a node is; 3 for a mid-side.
  int corner(std::int32_t face, std::int32_t node) const {
    int k = 0;
    while (k < 3 && faces(face, k) != node) ++k;
    return k;
  }
};

/// A quadrature point of a slave's face with its foot, the closest point, on a master's.
struct FacingPoint {
  Vector3 hats;               // of the corners
  double area;                // m^2, weight times the slave's curved area and how squarely both face each other
  double behind;              // m, how far it lies behind the master
  Vector3 normal;             // difference of both sides' unit normals
  FaceScalars slave, master;  // shape functions of both
  std::int32_t master_face;
};

/// The quadrature points at which the slave side faces the master (docs/theory/contact_faces.md, integrals): over
/// what the flat triangles of both share, seen along the slave's normal; where surfaces face away from each other,
/// none.
class FacingPoints {
 public:
  /// Both must outlive this.
  FacingPoints(const FacedSide& slave, const FacedSide& master);

  /// Forgets the points: positions have changed.
  void update();
  /// Of a slave's face at x; found once. O(points times master triangles that overlap).
  const std::vector<FacingPoint>& of(std::int32_t face, const Points& x);

 private:
  struct FaceFoot {
    std::int32_t face;
    FaceShapes shapes;
  };

  void find(std::int32_t triangle, const Points& x, std::vector<FacingPoint>& points);
  /// The master's triangles that overlap a slave's along its normal: those around the one closest to its centre,
  /// then those around each that does.
  std::vector<std::int32_t> facing_triangles(const std::array<Vector3, 3>& corners, const Points& x);
  /// The master's point closest to p: on the face of a triangle beside it, or where that ends on the face of the
  /// triangle that is closest of all.
  FaceFoot foot(std::int32_t triangle, const Vector3& p, const Points& x) const;

  const FacedSide &slave_, &master_;
  std::vector<std::optional<std::vector<FacingPoint>>> points_;  // by the slave's face
  std::vector<std::int32_t> known_;                              // faces whose points are known
  std::int64_t search_ = 0;
  std::vector<std::int64_t> seen_;  // by the master's triangle: the search that saw it last
};

}  // namespace plica

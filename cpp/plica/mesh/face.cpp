#include "plica/mesh/face.hpp"

namespace plica {

FaceShapes face_shapes(Eigen::Index nodes, double r, double s) {
  const double t = 1 - r - s;
  FaceShapes shapes;
  if (nodes == 3) {
    shapes.value = Vector3(t, r, s);
    shapes.along_r = Vector3(-1, 1, 0);
    shapes.along_s = Vector3(-1, 0, 1);
    return shapes;
  }
  shapes.value.resize(6);
  shapes.along_r.resize(6);
  shapes.along_s.resize(6);
  shapes.value << t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t;
  shapes.along_r << 1 - 4 * t, 4 * r - 1, 0, 4 * (t - r), 4 * s, -4 * s;
  shapes.along_s << 1 - 4 * t, 0, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s);
  return shapes;
}

const ParameterTriangle& parameter_triangle(Eigen::Index nodes, int k) {
  using P = Eigen::Vector2d;
  static const ParameterTriangle whole{P(0, 0), P(1, 0), P(0, 1)};
  static const std::array<ParameterTriangle, 4> quarters{{{P(0, 0), P(0.5, 0), P(0, 0.5)},
                                                          {P(0.5, 0), P(1, 0), P(0.5, 0.5)},
                                                          {P(0, 0.5), P(0.5, 0.5), P(0, 1)},
                                                          {P(0.5, 0), P(0.5, 0.5), P(0, 0.5)}}};
  return nodes == 6 ? quarters[static_cast<std::size_t>(k)] : whole;
}

}  // namespace plica

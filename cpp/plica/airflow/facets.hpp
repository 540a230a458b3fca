#pragma once
#include <vector>

#include "plica/mesh/face.hpp"

namespace plica {

/// A face as small flat triangles between points of it: 64 of a curved one with six nodes, one of three nodes.
class Facets {
 public:
  explicit Facets(Eigen::Index nodes_of_face) {
    const int parts = nodes_of_face == 6 ? 8 : 1;
    std::vector<std::ptrdiff_t> row_start;
    for (int j = 0; j <= parts; ++j) {
      row_start.push_back(static_cast<std::ptrdiff_t>(corners.size()));
      for (int i = 0; i + j <= parts; ++i) corners.emplace_back(double(i) / parts, double(j) / parts);
    }
    for (int j = 0; j < parts; ++j)
      for (int i = 0; i + j < parts; ++i) {
        const auto at = [&](int di, int dj) {
          return static_cast<int>(row_start[static_cast<std::size_t>(j + dj)]) + i + di;
        };
        triangles.push_back({at(0, 0), at(1, 0), at(0, 1)});
        if (i + j + 1 < parts) triangles.push_back({at(1, 0), at(1, 1), at(0, 1)});
      }
    weights.resize(static_cast<std::ptrdiff_t>(corners.size()), nodes_of_face);
    for (std::size_t c = 0; c < corners.size(); ++c)
      weights.row(static_cast<std::ptrdiff_t>(c)) =
          face_shapes(nodes_of_face, corners[c][0], corners[c][1]).value.transpose();
  }

  std::vector<Eigen::Vector2d> corners;       // (r, s)
  std::vector<std::array<int, 3>> triangles;  // of corners, turning as the face does
  Eigen::MatrixXd weights;                    // (corners, nodes of the face): shape functions there
};

}  // namespace plica

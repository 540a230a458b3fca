#include "bar.hpp"

#include <algorithm>
#include <array>

namespace {

constexpr double length = 0.02, width = 0.01;  // m

}  // namespace

plica::TetMesh make_bar(int along, int across) {
  const auto node = [=](int i, int j, int k) { return (i * (across + 1) + j) * (across + 1) + k; };
  plica::TetMesh mesh;
  mesh.points.resize(node(along, across, across) + 1, 3);
  std::vector<std::int32_t> clamp, tip;
  for (int i = 0; i <= along; ++i) {
    for (int j = 0; j <= across; ++j) {
      for (int k = 0; k <= across; ++k) {
        mesh.points.row(node(i, j, k)) << length * i / along, width * j / across, width * k / across;
        if (i == 0) clamp.push_back(node(i, j, k));
        if (i == along) tip.push_back(node(i, j, k));
      }
    }
  }

  // Six tetrahedra to a brick: one for each order in which the three directions are walked (Kuhn).
  std::vector<std::array<std::int32_t, 4>> cells;
  for (int i = 0; i < along; ++i) {
    for (int j = 0; j < across; ++j) {
      for (int k = 0; k < across; ++k) {
        std::array<int, 3> walk{0, 1, 2};
        do {
          std::array<int, 3> at{i, j, k};
          std::array<std::int32_t, 4> cell{node(i, j, k)};
          for (int step = 0; step < 3; ++step) {
            ++at[walk[step]];
            cell[step + 1] = node(at[0], at[1], at[2]);
          }
          const bool odd = (walk[0] > walk[1]) ^ (walk[0] > walk[2]) ^ (walk[1] > walk[2]);
          if (odd) std::swap(cell[2], cell[3]);
          cells.push_back(cell);
        } while (std::next_permutation(walk.begin(), walk.end()));
      }
    }
  }
  const auto count = static_cast<Eigen::Index>(cells.size());
  mesh.cells.resize(count, 4);
  for (Eigen::Index e = 0; e < count; ++e) {
    for (int a = 0; a < 4; ++a) mesh.cells(e, a) = cells[e][a];
  }
  mesh.node_sets["clamp"] = Eigen::Map<plica::Indices>(clamp.data(), static_cast<Eigen::Index>(clamp.size()));
  mesh.node_sets["tip"] = Eigen::Map<plica::Indices>(tip.data(), static_cast<Eigen::Index>(tip.size()));

  const plica::Faces faces = plica::boundary_of(mesh.cells).faces;
  std::vector<Eigen::Index> top;
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    bool on_top = true;
    for (const std::int32_t corner : faces.row(f)) on_top = on_top && mesh.points(corner, 2) > 0.999 * width;
    if (on_top) top.push_back(f);
  }
  mesh.surfaces["side"] = faces(top, Eigen::all);
  return mesh;
}

#include <algorithm>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/mesh/edges.hpp"
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

namespace {

template <class Map>
const typename Map::mapped_type& named(const Map& map, const std::string& name, const std::string& what) {
  const auto found = map.find(name);
  if (found != map.end()) return found->second;
  std::string text = "TetMesh: " + what + " = \"" + name + "\"; must be one of";
  for (const auto& entry : map) text += " \"" + entry.first + "\"";
  if (map.empty()) text += " (the mesh has none)";
  throw InvalidInput(text + ".");
}

}  // namespace

const Faces& TetMesh::surface(const std::string& name) const { return named(surfaces, name, "surface"); }

const Indices& TetMesh::node_set(const std::string& name) const { return named(node_sets, name, "node_set"); }

Boundary boundary_of(const Cells& cells) {
  require_size("boundary_of", "a cell", cells.cols(), 4, 10);
  struct Use {
    FaceKey key;
    std::int32_t place;  // 4 cell + local face
  };
  std::vector<Use> uses;
  uses.reserve(4 * cells.rows());
  for (Eigen::Index e = 0; e < cells.rows(); ++e)
    for (int f = 0; f < 4; ++f) {
      const auto& local = tet_faces[f];
      uses.push_back({face_key(cells(e, local[0]), cells(e, local[1]), cells(e, local[2])),
                      static_cast<std::int32_t>(4 * e + f)});
    }
  std::sort(uses.begin(), uses.end(), [](const Use& a, const Use& b) { return a.key < b.key; });

  std::vector<std::int32_t> single;
  for (std::size_t i = 0; i < uses.size();) {
    std::size_t next = i + 1;
    while (next < uses.size() && uses[next].key == uses[i].key) ++next;
    if (next == i + 1) single.push_back(uses[i].place);
    i = next;
  }
  std::sort(single.begin(), single.end());

  const int width = cells.cols() == 10 ? 6 : 3;
  Boundary result{Faces(single.size(), width), Indices(single.size())};
  for (std::size_t i = 0; i < single.size(); ++i) {
    result.cell_of_face[i] = single[i] / 4;
    for (int k = 0; k < width; ++k) result.faces(i, k) = cells(single[i] / 4, tet_faces[single[i] % 4][k]);
  }
  return result;
}

Triangles flat_triangles(const Faces& faces) {
  require_size("flat_triangles", "a face", faces.cols(), 3, 6);
  if (faces.cols() != 6) return faces;
  Triangles flat(4 * faces.rows(), 3);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const auto n = faces.row(f);
    flat.row(4 * f + 0) << n[0], n[3], n[5];
    flat.row(4 * f + 1) << n[3], n[1], n[4];
    flat.row(4 * f + 2) << n[5], n[4], n[2];
    flat.row(4 * f + 3) << n[3], n[4], n[5];
  }
  return flat;
}

}  // namespace plica

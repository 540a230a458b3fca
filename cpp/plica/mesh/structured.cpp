#include "plica/mesh/structured.hpp"

#include <algorithm>

#include "plica/core/require.hpp"

namespace plica {

void split_prism(const std::array<PrismCorner, 6>& prism, std::vector<std::array<std::int32_t, 4>>& cells) {
  const auto smaller = [](const PrismCorner& a, const PrismCorner& b) { return a.key < b.key; };
  const auto first = std::min_element(prism.begin(), prism.end(), smaller) - prism.begin();
  // Turned so that the corner of smallest key is a[0]; b lies across from a.
  std::array<PrismCorner, 3> a, b;
  for (int k = 0; k < 3; ++k) {
    const auto along = (first + k) % 3;
    a[k] = prism[first < 3 ? along : along + 3];
    b[k] = prism[first < 3 ? along + 3 : along];
  }
  const auto append = [&](const PrismCorner& p, const PrismCorner& q, const PrismCorner& r, const PrismCorner& s) {
    if (first < 3)
      cells.push_back({p.node, q.node, r.node, s.node});
    else  // seen from the other end, the base is clockwise
      cells.push_back({p.node, q.node, s.node, r.node});
  };
  append(a[0], b[0], b[1], b[2]);
  if (std::min(a[1].key, b[2].key) < std::min(a[2].key, b[1].key)) {  // the far quad is cut from a1 to b2
    append(a[0], a[1], a[2], b[2]);
    append(a[0], a[1], b[2], b[1]);
  } else {
    append(a[0], a[1], a[2], b[1]);
    append(a[0], a[2], b[2], b[1]);
  }
}

Cells as_cells(const std::vector<std::array<std::int32_t, 4>>& cells) {
  Cells array(static_cast<Eigen::Index>(cells.size()), 4);
  for (std::size_t e = 0; e < cells.size(); ++e)
    array.row(e) << cells[e][0], cells[e][1], cells[e][2], cells[e][3];
  return array;
}

Faces marked_faces(const Boundary& boundary, const std::vector<char>& marked) {
  require_at_least("marked_faces", "nodes of a face", boundary.faces.cols(), 3);
  require_indices("marked_faces", "node of a face", boundary.faces, static_cast<std::ptrdiff_t>(marked.size()));
  std::vector<Eigen::Index> rows;
  for (Eigen::Index f = 0; f < boundary.faces.rows(); ++f)
    if (marked[boundary.faces(f, 0)] && marked[boundary.faces(f, 1)] && marked[boundary.faces(f, 2)])
      rows.push_back(f);
  return boundary.faces(rows, Eigen::all);
}

}  // namespace plica

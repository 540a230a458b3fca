#include "../borders.hpp"
#include "plica/mesh/block.hpp"
#include "plica/mesh/edges.hpp"
#include "plica/mesh/jacobian.hpp"
#include "plica/mesh/mirror.hpp"
#include "plica/mesh/smoothing.hpp"

using namespace plica;
using borders::indices;
using borders::Longer;
using borders::sizes;

TEST_CASE("what measures cells refuses nodes that are not there, in linear and quadratic meshes") {
  for (const bool quadratic : {false, true}) {
    CAPTURE(quadratic);
    TetMesh mesh = block_mesh({});
    if (quadratic) mesh = to_quadratic(mesh);
    Points& x = mesh.points;
    Cells& cells = mesh.cells;
    for (const std::function<void()>& call : {std::function<void()>([&] { signed_volumes(x, cells); }),
                                              std::function<void()>([&] { folded_cells(x, cells); }),
                                              std::function<void()>([&] { first_folded_cell(x, cells); }),
                                              std::function<void()>([&] { least_jacobian_ratios(x, cells); })}) {
      sizes("x", x, call, Longer::unread);
      indices("cells", cells, call);
      const Cells good = cells;
      cells = good.leftCols(2);
      CHECK_THROWS_AS(call(), InvalidInput);
      cells = good;
    }
    std::vector<std::int32_t> suspects{0, 1};
    indices("suspects", suspects, [&] { folded_cells(x, cells, suspects); });
    std::int32_t cell = 0;
    borders::numbers<std::int32_t>("e", cell, {-1, 1000}, [&] { jacobian_at_node(x, cells, cell, 0); });
    std::int32_t node = 0;
    borders::numbers<std::int32_t>("k", node, {-1, 10}, [&] { jacobian_at_node(x, cells, 0, node); });
  }
}

TEST_CASE("what makes meshes of meshes refuses nodes that are not there") {
  TetMesh mesh = block_mesh({});
  indices("to_quadratic cells", mesh.cells, [&] { to_quadratic(mesh); });
  indices("to_quadratic surface", mesh.surfaces.at("x_min"), [&] { to_quadratic(mesh); });
  indices("to_quadratic node set", mesh.node_sets.at("x_min"), [&] { to_quadratic(mesh); });
  indices("body_of_nodes cells", mesh.cells, [&] { body_of_nodes(mesh); });
  for (const std::ptrdiff_t width : {0, 2, 5}) {
    CHECK_THROWS_AS(boundary_of(Cells::Zero(3, width)), InvalidInput);
    CHECK_THROWS_AS(unique_edges(Cells::Zero(3, width)), InvalidInput);
    CHECK_THROWS_AS(flat_triangles(Faces::Zero(3, width)), InvalidInput);
  }
  std::vector<Freedom> freedom(static_cast<std::size_t>(mesh.node_count()));
  const auto call = [&] { smooth_mesh(mesh.points, mesh.cells, freedom, 1); };
  sizes("smooth freedom", freedom, call);
  sizes("smooth x", mesh.points, call);
  indices("smooth cells", mesh.cells, call);
}

TEST_CASE("mirror images refuse vectors of another mesh") {
  TetMesh mesh;
  mesh.points.resize(5, 3);
  mesh.points << 0, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, -1, 0, 0;
  mesh.cells.resize(2, 4);
  mesh.cells << 0, 1, 2, 3, 0, 2, 1, 4;
  const MirrorImages images(mesh, Symmetry::half);
  Vector q = Vector::Zero(3 * images.nodes().size()), f = Vector::Zero(mesh.points.size()), sum = q;
  Points places = mesh.points;
  Indices nodes(1);
  nodes << 0;
  sizes("spread q", q, [&] { images.spread(q); });
  sizes("shared f", q, [&] { images.shared(q); });
  sizes("folded f", f, [&] { images.folded(f); });
  sizes("part_of field", f, [&] { images.part_of(f, "f", places); });
  sizes("part_of places", places, [&] { images.part_of(f, "f", places); });
  sizes("folded_symmetric force", f, [&] { images.folded_symmetric(f, "f", places); });
  sizes("add_folded f", f, [&] { images.add_folded(f, nodes, sum); });
  sizes("add_folded sum", sum, [&] { images.add_folded(f, nodes, sum); });
  indices("add_folded nodes", nodes, [&] { images.add_folded(f, nodes, sum); });
  indices("nodes_of", nodes, [&] { images.nodes_of(nodes); });
  indices("image", nodes, [&] { images.image(1, nodes[0]); });
  CHECK_THROWS_AS(images.image(2, 0), InvalidInput);
  CHECK_THROWS_AS(images.image(-1, 0), InvalidInput);
  for (const std::ptrdiff_t rows : {q.size() - 1, q.size() + 3, std::ptrdiff_t{0}}) {
    CHECK_THROWS_AS(images.unfolded(SparseMatrix(rows, q.size())), InvalidInput);
    CHECK_THROWS_AS(images.unfolded(SparseMatrix(q.size(), rows)), InvalidInput);
  }
}

#include "../borders.hpp"
#include "plica/mesh/block.hpp"
#include "plica/mesh/edges.hpp"
#include "plica/mesh/jacobian.hpp"
#include "plica/mesh/larynx.hpp"
#include "plica/mesh/mirror.hpp"
#include "plica/mesh/smoothing.hpp"

using namespace plica;
using borders::Empty;
using borders::indices;
using borders::Longer;
using borders::numbers;
using borders::refused;
using borders::sizes;

TEST_CASE("what measures cells refuses nodes that are not there, in linear and quadratic meshes") {
  for (const bool quadratic : {false, true}) {
    CAPTURE(quadratic);
    TetMesh mesh = block_mesh({});
    if (quadratic) mesh = to_quadratic(mesh);
    Points& x = mesh.points;
    Cells& cells = mesh.cells;
    const struct {
      const char *x, *cells;
      std::function<void()> call;
    } calls[] = {
        {"signed_volumes x", "signed_volumes cells", [&] { signed_volumes(x, cells); }},
        {"folded_cells x", "folded_cells cells", [&] { folded_cells(x, cells); }},
        {"first_folded_cell x", "first_folded_cell cells", [&] { first_folded_cell(x, cells); }},
        {"jacobian_at_node x", "jacobian_at_node cells",
         [&] {
           for (std::ptrdiff_t e = 0; e < cells.rows(); ++e) jacobian_at_node(x, cells, e, 0);
         }},
        {"least_jacobian_ratios x", "least_jacobian_ratios cells", [&] { least_jacobian_ratios(x, cells); }}};
    for (const auto& [of_x, of_cells, call] : calls) {
      sizes(of_x, x, call, Longer::unread);
      indices(of_cells, cells, call);
      const Cells good = cells;
      cells = good.leftCols(2);
      refused(of_cells, call);
      cells = good;
    }
    std::vector<std::int32_t> suspects{0, 1};
    indices("folded_cells suspects", suspects, [&] { folded_cells(x, cells, suspects); });
    std::int32_t cell = 0;
    borders::numbers<std::int32_t>("jacobian_at_node e", cell, {-1, 1000},
                                   [&] { jacobian_at_node(x, cells, cell, 0); });
    std::int32_t node = 0;
    borders::numbers<std::int32_t>("jacobian_at_node k", node, {-1, 10},
                                   [&] { jacobian_at_node(x, cells, 0, node); });
  }
}

TEST_CASE("what makes meshes of meshes refuses nodes that are not there") {
  TetMesh mesh = block_mesh({});
  indices("to_quadratic linear.cells", mesh.cells, [&] { to_quadratic(mesh); });
  indices("to_quadratic linear.surfaces", mesh.surfaces.at("x_min"), [&] { to_quadratic(mesh); });
  indices("to_quadratic linear.node_sets", mesh.node_sets.at("x_min"), [&] { to_quadratic(mesh); });
  indices("body_of_nodes mesh.cells", mesh.cells, [&] { body_of_nodes(mesh); });
  for (const std::ptrdiff_t width : {0, 2, 5}) {
    refused("boundary_of cells", [&] { boundary_of(Cells::Zero(3, width)); });
    CHECK_THROWS_AS(unique_edges(Cells::Zero(3, width)), InvalidInput);
    refused("flat_triangles faces", [&] { flat_triangles(Faces::Zero(3, width)); });
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
  sizes("MirrorImages::spread q", q, [&] { images.spread(q); });
  sizes("MirrorImages::shared f", q, [&] { images.shared(q); });
  sizes("MirrorImages::folded f", f, [&] { images.folded(f); });
  sizes("MirrorImages::require_symmetric_field field", f, [&] { images.require_symmetric_field(f, "f", places); });
  sizes("MirrorImages::require_symmetric_field places", places,
        [&] { images.require_symmetric_field(f, "f", places); });
  sizes("MirrorImages::part_of field", f, [&] { images.part_of(f, "f", places); });
  sizes("MirrorImages::part_of places", places, [&] { images.part_of(f, "f", places); });
  sizes("MirrorImages::folded_symmetric force", f, [&] { images.folded_symmetric(f, "f", places); });
  sizes("MirrorImages::add_folded f", f, [&] { images.add_folded(f, nodes, sum); });
  sizes("MirrorImages::add_folded sum", sum, [&] { images.add_folded(f, nodes, sum); });
  indices("MirrorImages::add_folded nodes", nodes, [&] { images.add_folded(f, nodes, sum); });
  indices("MirrorImages::nodes_of nodes", nodes, [&] { images.nodes_of(nodes); });
  indices("MirrorImages::image part_node", nodes, [&] { images.image(1, nodes[0]); });
  int copy = 0;
  numbers("MirrorImages::image copy", copy, {-1, 2}, [&] { images.image(copy, 0); });
  for (const std::ptrdiff_t rows : {q.size() - 1, q.size() + 3, std::ptrdiff_t{0}}) {
    refused("MirrorImages::unfolded folded", [&] { images.unfolded(SparseMatrix(rows, q.size())); });
    refused("MirrorImages::unfolded folded", [&] { images.unfolded(SparseMatrix(q.size(), rows)); });
  }
  sizes("MirrorImages::folded_symmetric places", places, [&] { images.folded_symmetric(f, "f", places); });
  std::vector<Triangles> sides{Triangles(1, 3)};
  sides[0] << 0, 1, 2;
  const auto symmetric = [&] { images.require_symmetric(sides, "a side", places); };
  sizes("MirrorImages::require_symmetric places", places, symmetric);
  indices("MirrorImages::require_symmetric sides", sides[0], symmetric);
  sizes("MirrorImages::part mesh.points", mesh.points, [&] { images.part(mesh); });
  sizes("MirrorImages::part mesh.cells", mesh.cells, [&] { images.part(mesh); });
  const auto make = [&] { MirrorImages(mesh, Symmetry::half); };
  sizes("MirrorImages::MirrorImages mesh.points", mesh.points, make);
  indices("MirrorImages::MirrorImages mesh.cells", mesh.cells, make);
  sizes("MirrorImages::MirrorImages mesh.cells", mesh.cells, make);

  std::int32_t node = 0;
  std::size_t plane = 0;
  const auto at_node = [&](const char* name, const std::function<void()>& call) {
    numbers<std::int32_t>(name, node, {-1, 5, 1 << 30}, call);
  };
  at_node("MirrorImages::node_of node", [&] { images.node_of(node); });
  at_node("MirrorImages::sign node", [&] { images.sign(node); });
  at_node("MirrorImages::count part_node", [&] { images.count(node); });
  at_node("MirrorImages::partner node", [&] { images.partner(plane, node); });
  at_node("MirrorImages::mirrored node", [&] { images.mirrored(plane, node); });
  at_node("MirrorImages::at node", [&] { images.at(node, q); });
  sizes("MirrorImages::at q", q, [&] { images.at(node, q); });
  numbers<std::size_t>("MirrorImages::partner plane", plane, {1, 2, std::size_t(-1)},
                       [&] { images.partner(plane, node); });
  numbers<std::size_t>("MirrorImages::mirrored plane", plane, {1, 2, std::size_t(-1)},
                       [&] { images.mirrored(plane, node); });
}

TEST_CASE("what makes meshes of numbers refuses numbers that no mesh has") {
  Block block;
  for (int& count : block.divisions)
    numbers("block_mesh block.divisions", count, {0, -1, 1 << 30}, [&] { block_mesh(block); });
  TetMesh first = block_mesh({}), second = first;
  first.layer_names = second.layer_names = {"body", "cover"};
  const auto combine = [&] { combine_meshes(first, second, "a.", "b."); };
  for (TetMesh* mesh : {&first, &second}) {
    const char* const name =
        mesh == &first ? "combine_meshes first.cell_layer" : "combine_meshes second.cell_layer";
    sizes(name, mesh->cell_layer, combine);
    sizes(mesh == &first ? "combine_meshes first.cell_side" : "combine_meshes second.cell_side", mesh->cell_side,
          combine, Longer::refused, Empty::none);
  }
  sizes(
      "labelled mesh.cell_layer", first.cell_layer, [&] { labelled(first); }, Longer::refused, Empty::none);
  sizes(
      "labelled mesh.cell_side", first.cell_side, [&] { labelled(first); }, Longer::refused, Empty::none);
  sizes("check_mesh mesh.points", first.points, [&] { check_mesh(first); });
  indices("check_mesh mesh.cells", first.cells, [&] { check_mesh(first); });
  indices("check_mesh mesh.surfaces", first.surfaces.at("x_min"), [&] { check_mesh(first); });
  indices("check_mesh mesh.node_sets", first.node_sets.at("x_min"), [&] { check_mesh(first); });
  CHECK(origin_near(Points(0, 3)).isZero(0.0));
  Larynx larynx = Larynx::thesis_coarse();
  auto& levels = std::get<Larynx::Levels>(larynx.meshed);
  sizes("larynx_mesh larynx.levels", levels.levels, [&] { larynx_mesh(larynx); });
  numbers("larynx_mesh larynx.around", levels.around, {0, -4, 10}, [&] { larynx_mesh(larynx); });
  numbers("quadratic_larynx_mesh larynx.around", levels.around, {0, -4, 10},
          [&] { quadratic_larynx_mesh(larynx); });
  numbers("larynx_mesh larynx.layers_to_section", larynx.shape.layers_to_section, {-1, 0, 100},
          [&] { larynx_mesh(larynx); });
  sizes("larynx_mesh larynx.sections", larynx.shape.sections, [&] { larynx_mesh(larynx); });
}

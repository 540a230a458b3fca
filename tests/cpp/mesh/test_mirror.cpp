#include <doctest/doctest.h>

#include "plica/core/error.hpp"
#include "plica/mesh/mirror.hpp"

using namespace plica;

namespace {

/// Two cells that are mirror images in x = 0, with three nodes there.
TetMesh two_cells() {
  TetMesh mesh;
  mesh.points.resize(5, 3);
  mesh.points << 0, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, -1, 0, 0;
  mesh.cells.resize(2, 4);
  mesh.cells << 0, 1, 2, 3, 0, 2, 1, 4;
  return mesh;
}

}  // namespace

TEST_CASE("forces shared among images sum to what is shared, alike on each, in the plane, too") {
  const MirrorImages images(two_cells(), Symmetry::half);
  REQUIRE(images.nodes().size() == 4);
  Vector f = Vector::LinSpaced(12, 1.0, 12.0);
  for (const std::ptrdiff_t in_plane : {0, 3, 6}) f[in_plane] = 0.0;
  const Vector shared = images.shared(f);
  CHECK(images.folded(shared) == f);
  CHECK(images.folded_symmetric(shared, "the force", two_cells().points) == f);
}

TEST_CASE("a part's field stays in the plane exactly, and one that is not symmetric is refused") {
  const TetMesh mesh = two_cells();
  const MirrorImages images(mesh, Symmetry::half);
  Vector field = Vector::Zero(15);
  field.tail<6>() << 1, 2, 3, -1, 2, 3;
  field[0] = 1e-9;  // round-off
  const Vector part = images.part_of(field, "the field", mesh.points);
  CHECK(part[0] == 0);
  CHECK(part.tail<3>() == Vector3(1, 2, 3));
  field[13] = 2 + 1e-4;
  CHECK_THROWS_AS(images.part_of(field, "the field", mesh.points), InvalidInput);
}

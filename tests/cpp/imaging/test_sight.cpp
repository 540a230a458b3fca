// What a camera sees of a surface: exact places in a curved face, and what the borders refuse.
#include <cmath>
#include <limits>

#include "../borders.hpp"
#include "plica/imaging/face_hits.hpp"
#include "plica/imaging/surface_values.hpp"
#include "plica/imaging/texture.hpp"

using namespace plica;
using namespace plica::imaging;
using borders::sizes;

namespace {

/// Anticlockwise seen from outside, the rows counting downwards; with six nodes one side bulges.
Points nodes() {
  Points x(6, 3);
  x << 0, 0, 1, 0, 8, 2, 8, 0, 3, 0, 4, 1.5, 4.4, 4.4, 2.5, 4, 0, 2;
  return x;
}
Faces six() { return (Faces(1, 6) << 0, 1, 2, 3, 4, 5).finished(); }
Triangles three() { return (Triangles(1, 3) << 0, 1, 2).finished(); }
Pairs pixels() { return (Pairs(3, 2) << 1, 2, 3, 1, 20, 20).finished(); }

}  // namespace

TEST_CASE("a line of sight meets a curved face where the face's own map says") {
  const Points x = nodes();
  const FaceHits hits = first_hits(x, six(), pixels());
  CHECK(hits.face == (Indices(3) << 0, 0, -1).finished());
  for (int p = 0; p < 2; ++p) {
    const double r = hits.place(p, 0), s = hits.place(p, 1), t = 1 - r - s;
    const Eigen::RowVectorXd shape = (Eigen::RowVectorXd(6) << t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1),
                                      4 * t * r, 4 * r * s, 4 * s * t)
                                         .finished();
    const Eigen::RowVectorXd at = shape * x;
    CHECK(std::abs(at[0] - pixels()(p, 0)) < 1e-9);
    CHECK(std::abs(at[1] - pixels()(p, 1)) < 1e-9);
  }
  const FaceHits near = hits_near(x, six(), Indices::Zero(2), pixels().topRows(2), Pairs::Constant(2, 2, 0.3));
  CHECK((near.place - hits.place.topRows(2)).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("nothing that is not finite is seen") {
  Points x = nodes();
  x(1, 2) = std::numeric_limits<double>::quiet_NaN();
  CHECK((rasterise_triangles(x, three(), PixelMask::Constant(9, 9, true)).triangle.array() < 0).all());
  x(1, 0) = std::numeric_limits<double>::infinity();
  CHECK(first_hits(x, six(), pixels()).face.maxCoeff() == -1);
  CHECK(std::isinf(heights_above(pixels(), x, three(), 9, 9).maxCoeff()));
  Pairs place = pixels();
  place.setConstant(std::numeric_limits<double>::quiet_NaN());
  CHECK(first_hits(nodes(), six(), place).face.maxCoeff() == -1);
}

TEST_CASE("sizes and rows that do not belong together are refused") {
  const Points x = nodes();
  Indices face = Indices::Zero(3);
  Pairs at = pixels(), start = Pairs::Constant(3, 2, 0.3);
  const auto near = [&] { hits_near(x, six(), face, at, start); };
  sizes("pixels", at, near);
  sizes("start", start, near);
  face[1] = 1;
  CHECK_THROWS_AS(near(), InvalidInput);
  const Points few = x.topRows(2);
  CHECK_THROWS_AS(first_hits(few, six(), at), InvalidInput);
  CHECK_THROWS_AS(rasterise_triangles(few, three(), PixelMask::Constant(2, 2, true)), InvalidInput);
  CHECK_THROWS_AS(heights_above(at, few, three(), 2, 2), InvalidInput);
  CHECK_THROWS_AS(heights_above(at, x, three(), -1, 2), InvalidInput);
  CHECK_THROWS_AS(corner_normals(few, three()), InvalidInput);
  Table weights = Table::Ones(1, 6);
  sizes("weights", weights, [&] { interpolated(weights, six(), x); });
  CHECK_THROWS_AS(interpolated(weights, six(), few), InvalidInput);
  Vector tile = Vector::Ones(64);
  sizes("tile", tile, [&] { periodic_spline(tile, 4, x, 3); });
  CHECK_THROWS_AS(periodic_spline(tile, 4, x, 2), InvalidInput);
  Points lost = x;
  lost(0, 0) = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(periodic_spline(tile, 4, lost, 3), InvalidInput);
}

#include <doctest/doctest.h>

#include <random>

#include "plica/dynamics/overlapping_widths.hpp"
#include "scenes.hpp"

using namespace plica;

namespace {

/// Areas as they are linear in positions: what they are of widths none of which counts zero.
Vector unclipped(const SectionAreas& areas, const Points& x) {
  const Vector widths = areas.widths(x);
  return areas.areas(widths.cwiseMax(0.0)) - areas.areas((-widths).cwiseMax(0.0));
}

}  // namespace

TEST_CASE("linear areas and what overlap takes from them are the areas of widths that count zero") {
  const Scene scene = scenes::small_larynx();
  const Airflow airflow(scene.mesh, scene.mesh.surface("airway"), {800.0, 1.23, ViscousSlit{}, CutSections{30}});
  const SectionAreas& areas = airflow.section_areas();
  const Points& rest = scene.mesh.points;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  // Both folds towards each other in the middle, and some shapes without sense.
  Eigen::MatrixXd shapes = 1e-4 * Eigen::MatrixXd::NullaryExpr(rest.size(), 6, [&] { return normal(random); });
  for (std::ptrdiff_t i = 0; i < rest.rows(); ++i)
    shapes(3 * i, 0) = (rest(i, 0) < 0 ? 1.0 : -1.0) * 1e-3 * std::exp(-1e5 * rest(i, 1) * rest(i, 1));
  OverlappingWidths overlap(areas, nullptr, rest, shapes);
  int overlapping = 0, open = 0;
  for (int step = 0; step < 400; ++step) {
    Vector q = Vector::NullaryExpr(6, [&] { return 0.1 * normal(random); });
    q[0] = 2 * std::sin(0.03 * step);  // in small moves, most of which let most widths alone
    const Vector moved = shapes * q;
    const Points x = rest + as_points(moved);
    const Vector expected = areas.areas(areas.widths(x));
    Vector found = unclipped(areas, x);
    const double taken = (expected - found).maxCoeff();
    overlap.add(q, found);
    CHECK((found - expected).cwiseAbs().maxCoeff() < 1e-15);
    OverlappingWidths anew(areas, nullptr, rest, shapes);  // what was computed before does not show
    Vector again = unclipped(areas, x);
    anew.add(q, again);
    CHECK(again == found);
    taken > 1e-12 ? ++overlapping : ++open;
  }
  CHECK(overlapping > 50);
  CHECK(open > 50);
}

TEST_CASE("of a symmetric motion overlap is read off its part") {
  const Scene scene = scenes::small_larynx();
  const Airflow airflow(scene.mesh, scene.mesh.surface("airway"), {800.0, 1.23, ViscousSlit{}, CutSections{30}});
  const SectionAreas& areas = airflow.section_areas();
  const MirrorImages images(scene.mesh, Symmetry::quarter);
  Eigen::MatrixXd shape = Eigen::MatrixXd::Zero(3 * images.nodes().size(), 1);  // behind the plane in the middle
  for (std::ptrdiff_t i = 0; i < images.nodes().size(); ++i)
    if (scene.mesh.points(images.nodes()[i], 1) < 4e-3) shape(3 * i, 0) = -1.5e-3;
  OverlappingWidths overlap(areas, &images, scene.mesh.points, shape);
  const Vector moved = images.spread(shape.col(0));
  const Points x = scene.mesh.points + as_points(moved);
  const Vector expected = areas.areas(areas.widths(x));
  Vector found = unclipped(areas, x);
  CHECK((found - expected).cwiseAbs().maxCoeff() > 1e-7);
  overlap.add(Vector::Ones(1), found);
  CHECK((found - expected).cwiseAbs().maxCoeff() < 1e-15);
}

TEST_CASE("elliptic areas have no overlap that counts zero") {
  const Scene scene = scenes::small_larynx();
  const Airflow airflow(scene.mesh, scene.mesh.surface("airway"), {800.0, 1.23, Bernoulli{}, EllipticSections{}});
  const Eigen::MatrixXd shape = Eigen::MatrixXd::Constant(scene.mesh.points.size(), 1, 1e-3);
  Vector areas = Vector::Constant(airflow.sections().count(), -1.0);
  OverlappingWidths(airflow.section_areas(), nullptr, scene.mesh.points, shape).add(Vector::Ones(1), areas);
  CHECK(areas == Vector::Constant(areas.size(), -1.0));
}

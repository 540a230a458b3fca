#include <doctest/doctest.h>

#include <random>

#include "plica/dynamics/overlapping_widths.hpp"
#include "scenes.hpp"

using namespace plica;

namespace {

/// Areas as they are linear in positions: what they are of widths none of which counts zero.
Vector linear(const SectionAreas& areas, const Points& x) {
  const Vector widths = areas.widths(x);
  return areas.areas(widths.cwiseMax(0.0)) - areas.areas((-widths).cwiseMax(0.0));
}

Vector of_nodes(const Points& x, const Indices& nodes) { return x(nodes, 0); }

}  // namespace

TEST_CASE("linear areas and what overlap takes from them are the areas of widths that count zero") {
  const Scene scene = scenes::small_larynx();
  const Airflow airflow(scene.mesh, scene.mesh.surface("airway"), {800.0, 1.23, ViscousSlit{}, CutSections{30}});
  const SectionAreas& areas = airflow.section_areas();
  OverlappingWidths overlap(areas, nullptr);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Points x = scene.mesh.points;
  int overlapping = 0, open = 0;
  for (int step = 0; step < 300; ++step) {
    // Small moves, most of which let a group alone, and some large ones; closed by and by, then opened again.
    const double size = step % 50 == 0 ? 2e-4 : 1e-6;
    for (double& value : x.reshaped()) value += size * normal(random);
    const double closing = step < 150 ? 0.99 : 1.01;
    x.col(0) *= closing;
    if (step % 3 == 0) x.col(0).array() -= 1e-5 * (step < 150 ? 1 : -1) * (x.col(0).array() > 0).cast<double>();
    const Vector expected = areas.areas(areas.widths(x));
    Vector found = linear(areas, x);
    const Vector taken = expected - found;
    overlap.add(of_nodes(x, overlap.nodes()), found);
    CHECK((found - expected).cwiseAbs().maxCoeff() < 1e-15);
    // What was looked at before does not show.
    OverlappingWidths anew(areas, nullptr);
    Vector again = linear(areas, x);
    anew.add(of_nodes(x, anew.nodes()), again);
    CHECK(again == found);
    taken.maxCoeff() > 1e-12 ? ++overlapping : ++open;
  }
  CHECK(overlapping > 30);
  CHECK(open > 30);
}

TEST_CASE("of a symmetric motion overlap is read off its part") {
  const Scene scene = scenes::small_larynx();
  const Airflow airflow(scene.mesh, scene.mesh.surface("airway"), {800.0, 1.23, ViscousSlit{}, CutSections{30}});
  const SectionAreas& areas = airflow.section_areas();
  const MirrorImages images(scene.mesh, Symmetry::quarter);
  OverlappingWidths overlap(areas, &images);
  CHECK(2 * overlap.nodes().size() < airflow.nodes().size());
  Points x = scene.mesh.points;
  for (std::ptrdiff_t i = 0; i < x.rows(); ++i)  // behind the plane in the middle
    if (std::abs(x(i, 1)) < 4e-3) x(i, 0) -= (x(i, 0) > 0 ? 1 : x(i, 0) < 0 ? -1 : 0) * 1.5e-3;
  const Vector expected = areas.areas(areas.widths(x));
  Vector found = linear(areas, x);
  CHECK((found - expected).cwiseAbs().maxCoeff() > 1e-7);
  overlap.add(of_nodes(x, overlap.nodes()), found);
  CHECK((found - expected).cwiseAbs().maxCoeff() < 1e-15);
}

TEST_CASE("elliptic areas have no overlap that counts zero") {
  const Scene scene = scenes::small_larynx();
  const Airflow airflow(scene.mesh, scene.mesh.surface("airway"), {800.0, 1.23, Bernoulli{}, EllipticSections{}});
  CHECK(OverlappingWidths(airflow.section_areas(), nullptr).nodes().size() == 0);
}

#include <doctest/doctest.h>

#include <random>

#include "plica/dynamics/reduced_areas.hpp"
#include "reduced_scenes.hpp"

using namespace plica;
using namespace scenes;

namespace {

/// A larynx that moves in these shapes, with sections of which some overlap when it does.
Scene moving_in(const Eigen::MatrixXd& shapes) {
  Scene scene = reduced(small_larynx(), shapes);
  scene.contact.reset();
  scene.airflow->flow.model = ViscousSlit{};
  scene.airflow->flow.area = CutSections{30};
  return scene;
}

}  // namespace

TEST_CASE("areas from mediolateral positions are those of widths that count zero where they are negative") {
  const Points rest = small_larynx().mesh.points;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  // Both folds towards each other in the middle, and some shapes without sense.
  Eigen::MatrixXd shapes = 1e-4 * Eigen::MatrixXd::NullaryExpr(rest.size(), 6, [&] { return normal(random); });
  for (std::ptrdiff_t i = 0; i < rest.rows(); ++i)
    shapes(3 * i, 0) = (rest(i, 0) < 0 ? 1.0 : -1.0) * 1e-3 * std::exp(-1e5 * rest(i, 1) * rest(i, 1));
  const Simulation simulation(moving_in(shapes), options(HilberHughesTaylor{}, 50e-6));
  const ModalMotion& motion = simulation.reduced()->motion();
  const Mediolateral& positions = simulation.reduced()->positions();
  const SectionAreas& areas = simulation.airflow()->section_areas();
  ReducedAreas reduced(areas, positions);
  int overlapping = 0, open = 0;
  for (int step = 0; step < 400; ++step) {
    // In small moves, most of which leave most widths alone.
    Vector by = Vector::NullaryExpr(6, [&] { return 0.1 * normal(random); });
    by[0] = 2 * std::sin(0.03 * step);
    Vector displacement = shapes * by;
    for (std::ptrdiff_t i = 0; i < displacement.size(); ++i)
      if (simulation.scene().supports.fixed(i)) displacement[i] = 0;
    const Vector q = motion.nearest(displacement), moved = motion.shapes() * q, x = positions.at(q);
    CHECK(relative(moved, displacement) < 1e-9);
    const Vector widths = areas.widths(rest + as_points(moved)), expected = areas.areas(widths);
    CHECK((reduced.at(x) - expected).cwiseAbs().maxCoeff() < 1e-15);
    CHECK(ReducedAreas(areas, positions).at(x) == reduced.at(x));  // what was computed before does not show
    widths.minCoeff() < -1e-6 ? ++overlapping : ++open;
  }
  CHECK(overlapping > 50);
  CHECK(open > 50);
}

TEST_CASE("areas of a symmetric motion are read off its part") {
  Scene scene = symmetric_folds();
  scene.contact.reset();
  scene.airflow->flow.model = ViscousSlit{};
  scene.airflow->flow.area = CutSections{30};
  scene.symmetry = Symmetry::quarter;
  const MirrorImages images(scene.mesh, Symmetry::quarter);
  Vector shape = Vector::Zero(3 * images.nodes().size());  // behind the plane in the middle
  for (std::ptrdiff_t i = 0; i < images.nodes().size(); ++i) {
    const std::int32_t node = images.nodes()[i];
    if (scene.mesh.points(node, 0) > 0 && scene.mesh.points(node, 1) < 4e-3 && !scene.supports.fixed(3 * node))
      shape[3 * i] = -1.5e-3;
  }
  const Vector moved = images.spread(shape);
  scene = reduced(scene, moved);
  const Simulation simulation(scene, options(HilberHughesTaylor{}, 50e-6));
  const ReducedModel& model = *simulation.reduced();
  const SectionAreas& areas = simulation.airflow()->section_areas();
  const Vector widths = areas.widths(scene.mesh.points + as_points(moved));
  CHECK(widths.minCoeff() < -1e-4);
  ReducedAreas reduced(areas, model.positions());
  const Vector x = model.positions().at(model.motion().nearest(shape));
  CHECK((reduced.at(x) - areas.areas(widths)).cwiseAbs().maxCoeff() < 1e-15);
}

TEST_CASE("elliptic areas are linear in the positions, negative ones too") {
  Scene scene = moving_in(Eigen::MatrixXd::Zero(0, 0));
  scene.airflow->flow.model = Bernoulli{};
  scene.airflow->flow.area = EllipticSections{};
  Vector together = Vector::Zero(scene.mesh.points.size());
  for (std::ptrdiff_t i = 0; i < scene.mesh.node_count(); ++i)
    if (!scene.supports.fixed(3 * i)) together[3 * i] = scene.mesh.points(i, 0) < 0 ? 5e-3 : -5e-3;
  scene = reduced(scene, together);
  const Simulation simulation(scene, options(HilberHughesTaylor{}, 50e-6));
  const ReducedModel& model = *simulation.reduced();
  const Airflow& airflow = *simulation.airflow();
  const Vector expected = airflow.areas(scene.mesh.points + as_points(together));
  CHECK(expected.minCoeff() < -1e-6);
  ReducedAreas reduced(airflow.section_areas(), model.positions());
  const Vector x = model.positions().at(model.motion().nearest(together));
  CHECK((reduced.at(x) - expected).cwiseAbs().maxCoeff() < 1e-15);
}

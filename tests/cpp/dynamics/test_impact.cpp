#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "../approx.hpp"
#include "convex_bodies.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::options;

namespace {

/// Pressure on the first body over one impact, step by step.
struct Impact {
  double duration = 0.0, impulse = 0.0, median = 0.0, peak = 0.0, duty = 0.0;
};
Impact impact_of(Simulation& simulation, double area, double end) {
  std::vector<double> pressure;
  Impact impact;
  int first = -1, last = -1;
  const double h = simulation.options().step;
  for (int k = 0; simulation.time() < end; ++k) {
    simulation.advance();
    const double p = simulation.record().contact->force_first.norm() / area;
    if (p == 0) continue;
    if (first < 0) first = k;
    last = k;
    pressure.push_back(p);
    impact.impulse += p * h;
  }
  REQUIRE(first >= 0);
  impact.duration = (last - first + 1) * h;
  impact.duty = static_cast<double>(pressure.size()) / (last - first + 1);
  std::nth_element(pressure.begin(), pressure.begin() + static_cast<std::ptrdiff_t>(pressure.size() / 2),
                   pressure.end());
  impact.median = pressure[pressure.size() / 2];
  impact.peak = *std::max_element(pressure.begin(), pressure.end());
  return impact;
}

}  // namespace

TEST_CASE("equal bars press with rho c v / 2 for 2 L / c and exchange their velocities") {
  const int n = 40;
  const double E = 20e3, rho = 1040, length = 0.01, c = std::sqrt(E / rho), exact = rho * c / 2;
  for (const Enforcement& enforcement :
       {Enforcement(Multipliers{Condensed{}, EndOfStep{}}), Enforcement(Multipliers{Saddle{}, EndOfStep{}}),
        Enforcement(Multipliers{Gmres{}, EndOfStep{}}), Enforcement(Augmented{}), Enforcement(Nitsche{}),
        Enforcement(Penalty{10 * E / (length / n) * (length / n) * (length / n) / 4})}) {
    Simulation simulation(scenes::two_bars(n, enforcement), options(HilberHughesTaylor{}, length / n / c));
    const Impact impact = impact_of(simulation, length / n * length / n, 2.6 * length / c);
    // The front is some elements wide, so on forty elements the duration is known to a step or two of 80.
    CHECK(impact.duration == approx(2 * length / c).epsilon(0.03));
    CHECK(impact.impulse / impact.duration == approx(exact).epsilon(0.03));
    CHECK(impact.median == approx(exact).epsilon(0.01));
    const Vector p = simulation.mass() * simulation.state().velocity;
    const auto half = simulation.scene().mesh.node_count() / 2;
    const double mass = rho * length * length / n * length / n;
    // What rings on in the bars is missing.
    CHECK(as_points(p).topRows(half).col(0).sum() / mass == approx(-0.5).epsilon(0.035));
    CHECK(as_points(p).bottomRows(half).col(0).sum() / mass == approx(0.5).epsilon(0.035));
  }
}

TEST_CASE("equal bars press with rho c v / 2 wherever they are") {
  const int n = 40;
  const double E = 20e3, rho = 1040, length = 0.01, c = std::sqrt(E / rho), exact = rho * c / 2, w = length / n;
  for (const double far : {0.0, 1.0, 1e3, 1e6}) {
    CAPTURE(far);
    Scene scene = scenes::two_bars(n, Multipliers{});
    scene.mesh.points.rowwise() += far * Eigen::RowVector3d(1, -0.3, 0.7);
    Simulation simulation(scene, options(HilberHughesTaylor{}, w / c));
    const Impact impact = impact_of(simulation, w * w, 2.6 * length / c);
    CHECK(impact.duration == approx(2 * length / c).epsilon(0.03));
    CHECK(impact.median == approx(exact).epsilon(0.01));
    const Points moved = scene.mesh.points + as_points(simulation.state().displacement);
    CHECK((simulation.positions() - moved).cwiseAbs().maxCoeff() <= 1e-15 * (far + length));
  }
}

// Coordinates are rounded where they are handed in. Of the same rounded ones, brought back to the origin, cubes
// make the same impact; with sums of coordinates and displacements at 1e6 m it would be 4e-3 of its peak off.
TEST_CASE("far from the origin an impact is that of the same coordinates near it") {
  const auto forces_of = [](const Scene& scene, double step) {
    Simulation simulation(scene, options(HilberHughesTaylor{}, step, 1e-13));
    Points forces(80, 3);
    for (int k = 0; k < 80; ++k) {
      simulation.advance();
      forces.row(k) = simulation.record().contact->force_first.transpose();
    }
    return forces;
  };
  for (const double far : {1.0, 1e3, 1e6}) {
    CAPTURE(far);
    const Eigen::RowVector3d offset = far * Eigen::RowVector3d(1, -0.3, 0.7);
    Scene there = scenes::two_cubes(Multipliers{}, 0.5, 3);
    there.mesh.points.rowwise() += offset;
    Scene here = there;
    here.mesh.points.rowwise() -= offset;
    const Points force = forces_of(there, 5e-5), expected = forces_of(here, 5e-5);
    CHECK(expected.rowwise().norm().maxCoeff() > 0.1);
    // The solver's tolerance, magnified by 80 steps of impact.
    CHECK((force - expected).rowwise().norm().maxCoeff() <= 1e-9 * expected.rowwise().norm().maxCoeff());
  }
}

// A step ends with the forces along the normals at the feet of its last pass, which are off the partner's corner
// by no more than what that pass still moved the nodes: the closer the gaps, the nearer to the axis.
TEST_CASE("bodies that are mirror images press along the axis, to some hundred times the contact's tolerance") {
  const auto tilt_at = [](unsigned seed, double tolerance) {
    Scene scene = convex::mirrored(seed, 1.0);
    scene.contact->options.tolerance = tolerance;
    Simulation simulation(scene, options(HilberHughesTaylor{}, 5e-5, 1e-13));
    double tilt = 0;
    int touching = 0;
    for (int k = 0; k < 60; ++k) {
      simulation.advance();
      const Points force = as_points(simulation.state().contact_force);
      if (simulation.record().contact->rows == 0) continue;
      ++touching;
      tilt = std::max(tilt, force.rightCols<2>().cwiseAbs().maxCoeff() / force.col(0).cwiseAbs().maxCoeff());
    }
    CHECK(touching > 20);
    return tilt;
  };
  for (const unsigned seed : {0u, 1u}) {
    CAPTURE(seed);
    for (const double tolerance : {1e-5, 1e-7, 1e-9}) CHECK(tilt_at(seed, tolerance) <= 1e3 * tolerance);
  }
}

TEST_CASE("without mass on the surfaces equal bars press evenly by the trapezoidal rule too") {
  const int n = 40;
  const double E = 20e3, rho = 1040, length = 0.01, c = std::sqrt(E / rho), exact = rho * c / 2;
  const auto impact_with = [&](SurfaceMass mass) {
    Scene scene = scenes::two_bars(n, Multipliers{});
    scene.contact->surface_mass = mass;
    Simulation simulation(scene, options(Newmark{}, length / n / c));
    return impact_of(simulation, length / n * length / n, 2.6 * length / c);
  };
  const Impact kept = impact_with(SurfaceMass::kept), moved = impact_with(SurfaceMass::redistributed);
  CHECK(kept.peak > 2.5 * exact);
  CHECK(kept.duty < 0.95);
  CHECK(moved.peak < 1.4 * exact);
  CHECK(moved.duty == 1);
  CHECK(moved.duration == approx(2 * length / c).epsilon(0.03));
  CHECK(moved.impulse / moved.duration == approx(exact).epsilon(0.03));
  CHECK(moved.median == approx(exact).epsilon(0.01));
}

TEST_CASE("quadratic bars on mortar faces exchange their velocities, and momentum stays") {
  const int n = 20;
  const double E = 20e3, rho = 1040, length = 0.01, c = std::sqrt(E / rho), exact = rho * c / 2, w = length / n;
  Simulation simulation(scenes::on_mortar_faces(scenes::two_bars(n, Multipliers{}), "a.x_max", "b.x_min"),
                        options(HilberHughesTaylor{}, w / 2 / c));
  const auto momentum = [&] {
    const Vector p = simulation.mass() * simulation.state().velocity;
    return as_points(p).colwise().sum().eval();
  };
  const Impact impact = impact_of(simulation, w * w, 2.6 * length / c);
  CHECK(impact.duration == approx(2 * length / c).epsilon(0.03));
  CHECK(impact.impulse / impact.duration == approx(exact).epsilon(0.03));
  CHECK(impact.median == approx(exact).epsilon(0.01));
  CHECK(momentum().norm() < 1e-10 * rho * length * w * w);  // of bodies that began with opposite ones
}

TEST_CASE("contact length is what the loaded nodes stand for, also that of a single line of nodes") {
  // Two plates of three elements along y that touch; where the nodes of one are pushed, it presses,
  // elsewhere it parts.
  const double w = 0.003;
  const TetMesh plate = block_mesh({{-0.002, 0, 0}, {0.002, w, 0.001}, {1, 3, 1}}),
                wide = block_mesh({{0, 0, 0}, {0.002, w, 0.001}, {1, 3, 1}});
  Scene scene = scenes::tissue_scene(combine_meshes(plate, wide, "a.", "b."), 0.0, 0.0);
  for (const auto node : scene.mesh.node_set("a.x_min")) scene.supports.fix(node);
  for (const auto node : scene.mesh.node_set("b.x_max")) scene.supports.fix(node);
  scene.velocity = Points::Zero(scene.mesh.node_count(), 3);
  scene.contact = scenes::contact_of(scene.mesh, "a.x_max", "b.x_min", Multipliers{});
  const auto length_where_pushed = [&](const auto& pushed) {
    Scene moving = scene;
    for (const auto node : scene.mesh.node_set("b.x_min"))
      (*moving.velocity)(node, 0) = pushed(scene.mesh.points(node, 1)) ? -0.5 : 0.5;
    Simulation::Options lumped = options(HilberHughesTaylor{}, 1e-6);
    lumped.mass = Simulation::Mass::lumped;  // so that a node moves alone
    Simulation simulation(moving, lumped);
    simulation.advance();
    CHECK(simulation.times().detection > 0);
    CHECK(simulation.times().contact >= 0);
    return simulation.record().contact->length;
  };
  CHECK(length_where_pushed([](double) { return true; }) == approx(w).epsilon(1e-3));
  CHECK(length_where_pushed([&](double y) { return std::abs(y - w / 3) < 0.1 * w; }) ==
        approx(w / 3).epsilon(1e-3));
}

TEST_CASE("bodies that touch at rest stay at rest without force") {
  Scene scene = scenes::two_bars(4, Multipliers{});
  scene.velocity->setZero();
  Simulation simulation(scene, options(HilberHughesTaylor{}, 1e-4));
  for (int k = 0; k < 10; ++k) simulation.advance();
  CHECK(simulation.state().displacement.isZero(0));
  CHECK(simulation.state().contact_force.isZero(0));
}

TEST_CASE("contact forces are opposite, none pulls, and no node stays inside") {
  for (const bool flow : {false, true}) {
    Simulation simulation(flow ? scenes::small_larynx() : scenes::two_cubes(Multipliers{}),
                          options(HilberHughesTaylor{}, 5e-5, 1e-8));
    const Airway& airway = simulation.collision()->detector().airway();
    std::vector<char> side(static_cast<std::size_t>(simulation.scene().mesh.node_count()), 0);
    for (const auto node : airway.first.reshaped()) side[static_cast<std::size_t>(node)] = 1;
    for (const auto node : airway.second.reshaped()) side[static_cast<std::size_t>(node)] = 2;
    int touching = 0;
    for (int k = 0; k < 60; ++k) {
      simulation.advance();
      const ContactRecord& record = *simulation.record().contact;
      CHECK(record.largest_multiplier <= 0);
      CHECK(record.deepest_gap >= -1e-4 * simulation.collision()->detector().mean_edge());
      if (record.rows == 0) continue;
      ++touching;
      Vector3 sum = Vector3::Zero();
      double size = 0;
      for (std::size_t i = 0; i < side.size(); ++i) {
        const Vector3 f = simulation.state().contact_force.segment<3>(3 * static_cast<std::ptrdiff_t>(i));
        if (side[i] == 0) CHECK(f.isZero(0));
        sum += f;
        size += f.norm();
      }
      CHECK(sum.norm() <= 1e-14 * size);
      CHECK((record.force_first + record.force_second).norm() <= 1e-14 * size);
    }
    CHECK(touching > 5);
  }
}

TEST_CASE(
    "each contact solver takes the same step from the same state of colliding folds, of cubes on mortar faces and "
    "of "
    "bodies that touch at t = 0") {
  const auto folds = [](const ContactSolver& solver) {
    Scene scene = scenes::small_larynx();
    scene.contact->enforcement = Multipliers{solver, EndOfStep{}};
    *scene.velocity *= 0.5;  // m/s; at 1 the tissue folds, and passes converge too slowly to compare
    scene.contact->options.tolerance = 1e-7;  // passes end elsewhere within it
    return scene;
  };
  const auto cubes = [](const ContactSolver& solver) {
    Scene scene =
        scenes::on_mortar_faces(scenes::two_cubes(Multipliers{solver, EndOfStep{}}), "a.x_max", "b.x_min");
    scene.contact->options.tolerance = 1e-7;
    return scene;
  };
  const auto bars = [](const ContactSolver& solver) {
    return scenes::two_bars(8, Multipliers{solver, EndOfStep{}});
  };
  const auto compare = [](const auto& scene_with, int steps) {
    const Simulation::Options tight = options(HilberHughesTaylor{}, 5e-5, 1e-12);
    Simulation leader(scene_with(Condensed{}), tight), saddle(scene_with(Saddle{}), tight),
        gmres(scene_with(Gmres{}), tight);
    REQUIRE(std::holds_alternative<Saddle>(*saddle.contact_solver()));
    int touching = 0;
    for (int k = 0; k < steps; ++k) {
      const State before = leader.state();
      leader.advance();
      const State& a = leader.state();
      for (Simulation* other : {&saddle, &gmres}) {
        other->restore(before);
        other->advance();
        const State& b = other->state();
        CHECK((a.displacement - b.displacement).norm() <= 1e-6 * (a.displacement - before.displacement).norm());
        CHECK((a.contact_force - b.contact_force).norm() <= 1e-5 * a.contact_force.norm());
      }
      touching += leader.record().contact->rows > 0;
    }
    CHECK(touching > 3);
  };
  compare(folds, 40);
  compare(cubes, 80);
  compare(bars, 20);
}

TEST_CASE("a penalty pushes each slave node with stiffness times its depth") {
  const double stiffness = 20.0;
  Simulation simulation(scenes::two_bars(8, Penalty{stiffness}), options(HilberHughesTaylor{}, 1e-4));
  const double tolerance = 2e-5 * simulation.collision()->detector().mean_edge() * stiffness;
  int pressing = 0;
  for (int k = 0; k < 20; ++k) {
    simulation.advance();
    const Points x = simulation.positions();
    for (const auto node : simulation.collision()->detector().slave_side().nodes()) {
      std::int32_t partner = -1;  // on rollers nodes stay face to face
      for (const auto other : simulation.collision()->detector().master_side().nodes())
        if ((x.row(node) - x.row(other)).tail<2>().norm() < 1e-9) partner = other;
      REQUIRE(partner >= 0);
      const double depth = x(node, 0) - x(partner, 0);
      const double push = -simulation.state().contact_force[3 * node];
      // The face tilts a little under consistent masses: its foot and normal differ from the partner's by that.
      CHECK(push == approx(std::max(0.0, stiffness * depth)).epsilon(0.02).scale(tolerance / 0.02));
      pressing += push > 10 * tolerance;
    }
  }
  CHECK(pressing > 20);
}

// The air in the glottis is accelerated: closed forms, its power, and what is remembered of it.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>

#include "../approx.hpp"
#include "plica/airflow/air_column.hpp"
#include "plica/airflow/flow_tangent.hpp"
#include "plica/core/constants.hpp"
#include "plica/core/error.hpp"
#include "tube.hpp"

using namespace plica;
using Instant = AirColumn::Instant;

namespace {

constexpr double length = 14e-3;  // m

/// A straight slit of 1 mm, or one that opens with its areas.
struct Straight {
  Airflow airflow;
  explicit Straight(Airflow::Options options, double viscosity = 1.8e-5) : airflow(made(options, viscosity)) {}
  static Airflow made(Airflow::Options options, double viscosity) {
    static const TetMesh mesh = slit(1e-3, length, 8e-3);
    options.model = ViscousSlit{1.2, viscosity, 3e-4, true};
    options.area = CutSections{9};
    return Airflow(mesh, mesh.surface("airway"), options);
  }
  const Vector& height() const { return airflow.sections().height; }
  double long_() const { return height()[8] - height()[0]; }
  Vector areas(double a) const { return Vector::Constant(9, a); }
  double density() const { return airflow.options().air_density; }
  double friction(double a, double viscosity = 1.8e-5) const {
    return 12 * viscosity * length * length * long_() / (a * a * a);
  }
};

/// The pressure is there at once after t = 0, and not before.
Airflow::Options at_once() {
  Airflow::Options options;
  options.rise = 1e-12;
  return options;
}

struct Reached {
  FlowState flow;
  double time;
};

Reached accelerated(const Straight& slit, double a, double step, double end, double ahead, Instant load) {
  AirColumn column(slit.airflow, step);
  CHECK(column.start(slit.areas(a)).flow == 0);
  AirColumn::Memory memory = column.remembered();
  Reached found{};
  for (int i = 0; i * step < end - 1e-9; ++i) {
    column.begin_step(memory, i * step, ahead * step, load);
    found = {column.evaluate(slit.areas(a), load), (load == Instant::last ? i : i + ahead) * step};
    memory = column.end_step(found.flow);
  }
  return found;
}

}  // namespace

TEST_CASE("under a pressure that is there at once the flow in a straight slit grows as Riccati's equation says") {
  // L dU/dt + R U + K U^2 = D from rest: U = 2 D tanh x / (S + R tanh x), S^2 = R^2 + 4 K D, x = S t / 2 L.
  for (const double a : {14e-6, 3e-6}) {  // next to no friction; half of the pressure
    const Straight slit(at_once());
    const double D = slit.airflow.options().subglottal_pressure, K = slit.density() / (2 * a * a);
    const double L = slit.density() * slit.long_() / a, R = slit.friction(a), S = std::sqrt(R * R + 4 * K * D);
    const double end = 2 * L / S;
    for (const auto& [load, ahead] :
         {std::pair(Instant::weighted, 1.0), std::pair(Instant::weighted, 0.7), std::pair(Instant::last, 0.7)}) {
      std::vector<double> errors;
      for (const int steps : {50, 100}) {
        const auto [flow, time] = accelerated(slit, a, end / steps, end, ahead, load);
        const double x = std::tanh(0.5 * S * time / L), exact = 2 * D * x / (S + R * x);
        errors.push_back(flow.flow / exact - 1);
        const double rate = (D - R * exact - K * exact * exact) / L;
        const double fall = D - K * exact * exact;  // along the slit, of which inertia takes a part
        CHECK(L * rate > 0.1 * D);
        for (int i = 0; i < 9; ++i) {
          const double left = (slit.height()[8] - slit.height()[i]) / slit.long_();
          CHECK(std::abs(flow.pressure[i] - left * fall) < 2e-3 * D);
        }
        CHECK(flow.momentum[4] ==
              approx(slit.density() / a * (slit.height()[4] - slit.height()[0]) * flow.flow).epsilon(1e-12));
        CHECK(flow.supplied_power ==
              approx(flow.jet_power + flow.viscous_power + flow.inertial_power).epsilon(1e-12));
        CHECK(flow.inertial_power == approx(L * rate * exact).epsilon(0.01));
      }
      CHECK(std::abs(errors[1]) < 1e-3);
      CHECK(std::abs(errors[0] / errors[1]) > 3);  // second order
    }
  }
}

TEST_CASE("small oscillations of the pressure meet the impedance R' + i omega L") {
  const double a = 14e-6, mean = 100, swing = 1, omega = 1600;
  const int steps = 200, periods = 8;
  const double step = 2 * pi / omega / steps;
  Airflow::Options options;
  options.course.emplace();
  for (int i = 0; i <= steps * periods; ++i) {
    options.course->time.push_back(i * step);
    options.course->pressure.push_back(mean + swing * std::cos(omega * i * step));
  }
  options.subglottal_pressure = mean + swing;
  const Straight slit(options);
  AirColumn column(slit.airflow, step);
  column.start(slit.areas(a));
  AirColumn::Memory memory = column.remembered();
  std::complex<double> flow = 0, pressure = 0;
  for (int i = 0; i < steps * periods; ++i) {
    column.begin_step(memory, i * step, step);
    const FlowState state = column.evaluate(slit.areas(a), Instant::weighted);
    memory = column.end_step(state);
    if (i < steps * (periods - 1)) continue;
    const auto turned = std::polar(1.0, -omega * (i + 1) * step);
    flow += turned * state.flow;
    pressure += turned * state.subglottal_pressure;
  }
  const double R = slit.friction(a), K = slit.density() / (2 * a * a), S = std::sqrt(R * R + 4 * K * mean);
  const double L = slit.density() * slit.long_() / a;
  const std::complex<double> exact(S, omega * L), found = pressure / flow;  // R + 2 K U = S
  CHECK(omega * L / S == approx(1).epsilon(0.2));
  CHECK(std::abs(found - exact) < 1e-3 * std::abs(exact));
}

TEST_CASE("without a pressure the momentum decays however the walls of a straight slit move") {
  // U = Phi a / (rho l): dPhi/dt = -Phi^2 / (2 rho l^2), whatever a(t), without friction.
  Airflow::Options options;
  options.course.emplace();
  options.course->time = {0.0, 1e-12};
  options.course->pressure = {800.0, 0.0};
  const Straight slit(options, 0.0);
  const auto open = [&](double time) { return slit.areas(14e-6 * (1 + 0.6 * std::sin(4000 * time))); };
  std::vector<double> errors;
  for (const double step : {1e-5, 5e-6}) {
    AirColumn column(slit.airflow, step);
    const double before = column.start(open(0)).momentum[8];
    AirColumn::Memory memory = column.remembered();
    double time = 0;
    FlowState flow;
    for (int i = 0; i * step < 1e-3 - 1e-9; ++i) {
      column.begin_step(memory, i * step, step);
      time = (i + 1) * step;
      flow = column.evaluate(open(time), Instant::weighted);
      memory = column.end_step(flow);
    }
    const double rho_l = slit.density() * slit.long_();
    const double exact = before / (1 + before * time / (2 * rho_l * slit.long_()));
    errors.push_back(flow.momentum[8] / exact - 1);
    CHECK(flow.flow == approx(exact * open(time)[0] / rho_l).epsilon(1e-3));
    CHECK(exact < 0.5 * before);
  }
  CHECK(std::abs(errors[1]) < 1e-4);
  CHECK(std::abs(errors[0] / errors[1]) > 3);
}

TEST_CASE("what accelerates the air is what ends, jet, friction and walls leave, displaced air included") {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> share(-1, 1);
  for (int i = 0; i < 60; ++i) {
    const Vector height = Vector::LinSpaced(8, 0.0, 4e-3), width = Vector::Constant(8, length);
    Vector areas(8);
    for (double& a : areas) a = 2.1e-5 + 1.9e-5 * share(random);
    AirwayExpansion moving{1e-5 * share(random), Vector(8), 1e-5 * share(random)};
    for (double& w : moving.sections) w = 1e-5 * share(random);
    ViscousSlit model{1.2, i % 3 ? 1e-3 : 0.0, 3e-4, true};
    AirInertia inertia{2e4, Vector::Zero(8)};
    for (int k = 1; k < 8; ++k) inertia.past[k] = inertia.past[k - 1] + 60 * (1 + share(random));
    Air air;
    air.subglottal_pressure = 500 * share(random);
    air.supraglottal_pressure = 40;
    if (i % 2) air.subglottal_impedance = 8e5;
    if (i % 4 > 1) air.supraglottal_impedance = 1.5e6;
    air.inertia = &inertia;
    const FlowState flow = viscous_slit_flow(model, air, {height, width}, areas, &moving);
    const double in = flow.subglottal_pressure * flow.flow_below,
                 out = flow.supraglottal_pressure * flow.flow_above;
    const double walls = flow.subglottal_pressure * moving.below + flow.pressure.dot(moving.sections) +
                         flow.supraglottal_pressure * moving.above;
    const double scale = std::abs(in) + std::abs(out) + std::abs(flow.jet_power) + 1e-3;
    CHECK(std::abs(in - out - walls - flow.supplied_power) < 1e-12 * scale);
    CHECK(std::abs(flow.supplied_power - flow.jet_power - flow.viscous_power - flow.inertial_power) <
          1e-12 * scale);
    CHECK(std::abs(flow.inertial_power) > 1e-6);
    CHECK(flow.flow_below - flow.flow_above == approx(moving.total()).epsilon(1e-10));
  }
}

TEST_CASE("walls of a straight slit that open draw air from below, to first order in their rate") {
  // The jet has the velocity v = sqrt(2 D / rho) whatever a(t), p = -rho v a' / a (z_s - z), and the air gains
  // d/dt (rho l a v^2 / 2) beside what this pressure gives to the walls.
  const int count = 41;
  const double l = 4e-3, a = 1e-5, D = 600, density = 1.23, v = std::sqrt(2 * D / density), dz = l / (count - 1);
  const Vector height = Vector::LinSpaced(count, 0.0, l), width = Vector::Constant(count, length);
  const AirInertia inertia{2e4, 2e4 * density * v * height};  // momenta stay as they are
  Air air;
  air.subglottal_pressure = D;
  air.density = density;
  air.inertia = &inertia;
  for (const double opening : {3e-3, -3e-3}) {  // m^2/s
    AirwayExpansion moving{0.0, Vector::Constant(count, opening * dz), 0.0};
    moving.sections[0] *= 0.5;
    moving.sections[count - 1] *= 0.5;
    const FlowState flow =
        viscous_slit_flow({1.2, 0.0, 3e-4, true}, air, {height, width}, Vector::Constant(count, a), &moving);
    CHECK(flow.flow == approx(v * a).epsilon(1e-12));
    CHECK(flow.flow_below - flow.flow == approx(opening * l).epsilon(1e-12));
    CHECK(flow.flow_above == approx(flow.flow).epsilon(1e-12));
    for (int i = 1; i + 1 < count; ++i)
      CHECK(flow.pressure[i] == approx(-density * v * opening / a * (l - height[i])).epsilon(1e-9));
    const double gained = 0.5 * density * l * opening * v * v, walls = flow.pressure.dot(moving.sections);
    CHECK(walls == approx(-0.5 * density * v * opening * opening * l * l / a).epsilon(1e-3));
    CHECK(flow.inertial_power == approx(gained - walls).epsilon(1e-9));
  }
}

TEST_CASE("nothing in the jet, and the wall pressure of a slit with inertance is continuous where it leaves") {
  Vector height = Vector::LinSpaced(5, 0.0, 2e-3), areas(5);
  const Vector width = Vector::Constant(5, length);
  areas << 4e-5, 1e-5, 1.1e-5, 3e-5, 5e-5;
  const AirwayExpansion moving{0.0, Vector::Constant(5, 1e-6), 0.0};
  const ViscousSlit model{1.2, 0.0, 3e-4, true};
  const FlowState still = viscous_slit_flow(model, {}, {height, width}, areas);
  const FlowState flow = viscous_slit_flow(model, {}, {height, width}, areas, &moving);
  const double density = Air{}.density;
  const auto lower = [&](int i, double filled) { return -density * flow.flow * filled / (areas[i] * areas[i]); };
  const Vector change = flow.pressure - still.pressure;
  CHECK(change[0] == approx(lower(0, 2e-6)).epsilon(1e-9));  // half of its own, the throat's, half of the next
  CHECK(change[1] == approx(lower(1, 1e-6)).epsilon(1e-9));
  CHECK(change[2] == approx(lower(2, 0.25e-6)).epsilon(1e-9));
  CHECK(change[3] == 0);
  CHECK(change[4] == 0);
  CHECK(flow.flow_below - flow.flow == approx(2.5e-6).epsilon(1e-9));
}

TEST_CASE("areas between sections are linear: a wedge has a logarithm") {
  Vector height(3), areas(3);
  const Vector width = Vector::Constant(3, length);
  height << 0, 1e-3, 4e-3;
  areas << 2e-5, 2.07e-5, 5e-6;  // a series, and not
  const FlowState flow = viscous_slit_flow({1.2, 0.0, 3e-4, true}, {}, {height, width}, areas);
  const double density = Air{}.density;
  CHECK(flow.momentum[0] == 0);
  CHECK(flow.momentum[1] == approx(density * flow.flow * 1e-3 * std::log(2.07 / 2) / 7e-7).epsilon(1e-12));
  CHECK(flow.momentum[2] - flow.momentum[1] ==
        approx(density * flow.flow * 3e-3 * std::log(2.07e-5 / 5e-6) / 1.57e-5).epsilon(1e-12));
  CHECK(flow.inertial_power == 0);
  CHECK(viscous_slit_flow({}, {}, {height, width}, areas).momentum.size() == 0);
}

TEST_CASE("after long steps nothing is left of the past") {
  const Straight slit(at_once());
  const FlowState steady = slit.airflow.evaluate(slit.areas(3e-6));
  AirColumn column(slit.airflow, 1e6);
  column.start(slit.areas(9e-6));
  column.begin_step(column.remembered(), 0.0, 1e6);
  const FlowState flow = column.evaluate(slit.areas(3e-6), Instant::weighted);
  CHECK(flow.flow == approx(steady.flow).epsilon(1e-9));
  CHECK((flow.pressure - steady.pressure).cwiseAbs().maxCoeff() < 1e-6);
}

TEST_CASE("a steady flow between tubes goes on, and its memory is what its numbers say") {
  Airflow::Options options;
  const Straight slit(options);
  Tubes tubes;
  tubes.trachea = Tube{{0.15}, {2e-4}, PressureSupply{0.2}};
  tubes.tract = Tube{{0.17}, {3e-4}, Radiation{}, YieldingWall{}};
  for (const bool between : {true, false}) {
    AirColumn column(slit.airflow, 1e-4, between ? tubes : Tubes{});
    const FlowState first = column.start(slit.areas(1e-5));
    AirColumn::Memory memory = column.remembered();
    for (int i = 0; i < 20; ++i) {
      column.begin_step(AirColumn::Memory::of(memory.numbers()), i * 1e-4, 0.7e-4);
      const FlowState flow = column.evaluate(slit.areas(1e-5), Instant::weighted);
      CHECK(flow.flow == approx(first.flow).epsilon(1e-9));
      CHECK(std::abs(flow.inertial_power) < 1e-9 * flow.supplied_power);
      memory = column.end_step(flow);
    }
    CHECK(memory.interval == 1e-4);
    CHECK(memory.momentum[8] == approx(slit.density() * slit.long_() / 1e-5 * first.flow).epsilon(1e-9));
    const AirColumn::Memory same = AirColumn::Memory::of(memory.numbers());
    CHECK(same.numbers() == memory.numbers());
    CHECK(same.momentum == memory.momentum);
    CHECK(same.momentum_before == memory.momentum_before);
    CHECK(same.trachea == memory.trachea);
    column.require(same);
    AirColumn::Memory wrong = same;
    wrong.momentum = Vector::Zero(8);
    CHECK_THROWS_AS(column.require(wrong), InvalidInput);
    wrong = same;
    wrong.momentum_before[3] = NAN;
    CHECK_THROWS_AS(column.require(wrong), InvalidInput);
    wrong = same;
    wrong.interval = -1;
    CHECK_THROWS_AS(column.require(wrong), InvalidInput);
  }
}

TEST_CASE("momenta answer to areas and to the drop as their tangent says, and without inertance there are none") {
  Airflow::Options options;
  const Straight slit(options);
  const double a = 1.5e-6, D = 800;
  const FlowTangent found = flow_tangent(slit.airflow, slit.areas(a), {D, 1.23});
  // Phi_s = rho l U / a; with U = 2 D / (R + S) and S^2 = R^2 + 2 rho D / a^2: dU/dD = 1 / S.
  const double R = slit.friction(a), S = std::sqrt(R * R + 2 * 1.23 * D / (a * a));
  const double L = 1.23 * slit.long_() / a;
  CHECK(found.flow_by_drop == approx(1 / S).epsilon(1e-7));
  CHECK(found.momentum_by_drop[8] == approx(L / S).epsilon(1e-7));
  CHECK(found.momentum_by_drop[0] == 0);
  Vector narrowing(9), way(9);
  for (int i = 0; i < 9; ++i) {
    narrowing[i] = a * (1.4 - 0.05 * i);
    way[i] = a * std::sin(2.3 * i);
  }
  const FlowTangent smooth = flow_tangent(slit.airflow, narrowing, {D, 1.23});
  std::vector<double> left;
  for (const double part : {1e-3, 5e-4}) {
    const FlowState moved = slit.airflow.evaluate(narrowing + part * way, {D + 300 * part, 1.23});
    const Vector change = part * (smooth.momentum_by_area * way + 300 * smooth.momentum_by_drop);
    left.push_back((moved.momentum - smooth.state.momentum - change).norm());
    CHECK(left.back() < 0.05 * change.norm());
  }
  CHECK(left[0] / left[1] == approx(4).epsilon(0.02));
  AirwayExpansion moving{0.0, 1e-7 * way / a, 0.0};
  const FlowState filled = slit.airflow.evaluate(narrowing, {D, 1.23}, false, std::nullopt, &moving);
  const Vector lower = filled.pressure - smooth.state.pressure;
  CHECK((lower - smooth.pressure_by_expansion * moving.sections).norm() < 1e-9 * lower.norm());
  CHECK(filled.flow_below - filled.flow == approx(smooth.from_below.dot(moving.sections)).epsilon(1e-9));
  CHECK(lower.norm() > 0);
  options.model = ViscousSlit{};
  static const TetMesh mesh = ::slit(1e-3, length, 8e-3);
  const FlowTangent without =
      flow_tangent(Airflow(mesh, mesh.surface("airway"), options), Vector::Constant(200, a), {D, 1.23});
  CHECK(without.momentum_by_drop.size() == 0);
  CHECK(without.momentum_by_area.size() == 0);
  CHECK(without.pressure_by_expansion.size() == 0);
}

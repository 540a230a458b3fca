#include "../borders.hpp"
#include "plica/dynamics/anderson.hpp"
#include "plica/dynamics/statics.hpp"
#include "plica/dynamics/waveforms.hpp"
#include "scenes.hpp"

using namespace plica;
using borders::Empty;
using borders::indices;
using borders::Longer;
using borders::numbers;
using borders::refused;
using borders::sizes;

TEST_CASE("a simulation and statics refuse a scene whose parts are of another mesh") {
  Scene scene = scenes::two_cubes(Multipliers{});
  scene.displacement = Points::Zero(scene.mesh.node_count(), 3);
  const Simulation::Options options{HilberHughesTaylor{}, 1e-4, {}};
  for (const auto& [name, call] :
       {std::pair<const char*, std::function<void()>>{"Simulation::Simulation scene",
                                                      [&] { Simulation(scene, options); }},
        {"equilibrium scene", [&] { equilibrium(scene); }},
        {"StretchedStatics::StretchedStatics scene", [&] { StretchedStatics of(scene); }},
        {"contact_equilibrium scene", [&] { contact_equilibrium(scene); }}}) {
    sizes(name, *scene.displacement, call);
    sizes(name, *scene.velocity, call);
    sizes(name, scene.tissue.cell_material, call);
    sizes(name, scene.mesh.points, call);
    indices(name, scene.mesh.cells, call);
    indices(name, scene.contact->airway.first, call);
    indices(name, scene.contact->airway.tets, call);
    const Supports good = scene.supports;
    scene.supports = Supports(good.size() / 3 - 1);
    refused(name, call);
    scene.supports = good;
  }
}

TEST_CASE("statics of tissue at finite strain refuse a displacement that is not its scene's") {
  const Scene scene = scenes::held_block();
  const StretchedStatics statics(scene);
  Vector u = Vector::Zero(3 * scene.mesh.node_count());
  sizes("StretchedStatics::unbalanced u", u, [&] { statics.unbalanced(u); });
  sizes("StretchedStatics::slope u", u, [&] { statics.slope(u); });
}

TEST_CASE("a simulation refuses nodes, forces and states that are not its scene's") {
  Scene scene = scenes::held_block(0.3, 1.0);
  scene.loads.push_back({"x_max", {1.0, 0, 0}, 0.0, 0.0});
  Simulation simulation(scene, {HilberHughesTaylor{}, 1e-4, {}});
  simulation.advance();
  Indices nodes(2);
  nodes << 0, static_cast<std::int32_t>(scene.mesh.node_count()) - 1;
  indices("Simulation::displacement_of nodes", nodes, [&] { simulation.displacement_of(nodes); });
  Vector force = Vector::Zero(3 * scene.mesh.node_count());
  sizes("Simulation::set_external_force force", force, [&] { simulation.set_external_force(force); });
  State state = simulation.state();
  for (Vector* part :
       {&state.displacement, &state.velocity, &state.acceleration, &state.load, &state.elastic_force,
        &state.weighted_elastic_force, &state.viscous_force, &state.inertial_force, &state.stiffness_velocity,
        &state.stiffness_acceleration, &state.viscosity_velocity, &state.viscosity_acceleration}) {
    sizes("Simulation::restore state", *part, [&] { simulation.restore(state); });
    sizes("Simulation::renewed state", *part, [&] { simulation.renewed(state); });
  }
  Recorder recorder(simulation, {}, nodes);
  std::ptrdiff_t steps = 2;
  numbers<std::ptrdiff_t>("Recorder::reserve steps", steps, {-1, -100}, [&] { recorder.reserve(steps); });
  indices("Recorder::Recorder probes", nodes, [&] { Recorder(simulation, {}, nodes); });
  refused("Recorder::Recorder names", [&] { Recorder(simulation, {"no such waveform"}); });
}

TEST_CASE("mixing refuses images of another length") {
  Anderson mixing(2);
  Vector x = Vector::Ones(4), image = Vector::Zero(4);
  const auto next = [&] { mixing.next(x, image); };
  sizes("Anderson::next x", x, next);
  sizes("Anderson::next image", image, next);
  Secant difference{Vector::Ones(4), Vector::Ones(4)};
  const auto taught = [&] {
    Anderson other(2);
    other.take(difference);
    other.next(x, image);
  };
  sizes("Anderson::take difference.image", difference.image, taught);
  sizes("Anderson::take difference.residual", difference.residual, taught);
  sizes("Anderson::next x", x, taught);
}

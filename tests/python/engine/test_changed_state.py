"""A state whose velocity was changed goes on as a body that starts from there."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import plica


def bar(step: float, viscosity: float) -> plica.Scene:
    return plica.Scene(
        plica.Block(size=("10 mm", "2 mm", "2 mm"), divisions=(6, 2, 2)),
        {"body": plica.Tissue(E="20 kPa", nu=0.3, viscosity=viscosity)},
        time=plica.Stepping(step=step, duration="20 ms"),
        supports=plica.Supports(fixed=("x_min",)),
        initial=plica.Initial(velocity={"body": (0, 0.1, 0)}),
    )


def kicked(step: float, viscosity: float) -> tuple[float, float]:
    """Difference from a fresh start with half of the velocity, over the displacement, and of the ledger."""
    scene, steps = bar(step, viscosity), round(1e-3 / step)
    simulation = plica.build_simulation(scene)
    simulation.advance(steps)
    state = simulation.state()
    u, v = np.array(simulation.displacement), np.array(simulation.velocity)
    simulation.restore(simulation.renewed({**state, "velocity": 0.5 * np.asarray(state["velocity"])}))
    fresh = plica.build_simulation(scene, displacement=u, velocity=0.5 * v)
    simulation.advance(steps)
    fresh.advance(steps)
    expected = np.asarray(fresh.displacement)
    end = simulation.state()
    lost = end["kinetic"] + end["elastic"] + end["viscous_loss"] + end["numerical_loss"] - end["load_work"]
    return (
        float(np.abs(simulation.displacement - expected).max() / np.abs(expected).max()),
        abs(lost / end["initial"] - 1),
    )


def test_a_changed_velocity_goes_on_as_from_a_fresh_start_to_second_order() -> None:
    """The acceleration stays that of the last step: of an elastic body, that of a new one's first step."""
    off = [kicked(step, viscosity=0.0) for step in (40e-6, 20e-6, 10e-6)]
    assert off[0][0] < 1e-4
    for (coarser, _), (finer, _) in pairwise(off):
        assert 3 < coarser / finer < 6
    assert max(ledger for _, ledger in off) < 1e-9


def test_a_viscous_body_has_the_acceleration_of_the_velocity_before_for_one_step() -> None:
    off = [kicked(step, viscosity=0.5) for step in (40e-6, 10e-6)]
    assert off[0][0] < 1e-4
    assert off[1][0] < 1e-4
    assert off[1][1] < 0.3 * off[0][1] < 1e-3  # what that step's viscous work misses falls with it


def test_a_state_renewed_without_a_change_goes_on_as_it_would() -> None:
    simulation, other = (plica.build_simulation(bar(40e-6, 0.5)) for _ in range(2))
    simulation.advance(20)
    other.restore(other.renewed(simulation.state()))
    simulation.advance(20)
    other.advance(20)
    size = np.abs(simulation.displacement).max()
    np.testing.assert_allclose(other.displacement, simulation.displacement, rtol=0, atol=1e-9 * size)


@pytest.mark.parametrize("name", ["displacement", "acceleration"])
def test_what_else_was_changed_is_refused_until_it_is_renewed(name: str) -> None:
    simulation = plica.build_simulation(bar(40e-6, 0.5))
    simulation.advance(5)
    changed = dict(simulation.state())
    changed[name] = 1.01 * np.asarray(changed[name])
    with pytest.raises(plica.InvalidInput, match="renewed"):
        simulation.restore(changed)
    simulation.restore(simulation.renewed(changed))
    simulation.advance(1)

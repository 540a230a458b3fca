"""Explicit steps of tissue at finite strain: second algorithms, what they keep, and their largest step."""

from __future__ import annotations

import re
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import plica
from plica import InvalidInput, StepFailed, _engine
from stretched_bodies import (
    DENSITY,
    FIBRED,
    STIFFENS,
    Law,
    angular_momentum,
    block,
    resumed_on_two_threads,
    simulation,
    tissue_force,
    voice,
)

CENTRAL = _engine.CentralDifferences()
BAR, PULL = (1e-3, 8e-3, 1e-3), 10e3


def fibred(stiffening: float = 2.0, matrix: float = 3.0, viscosity: float = 0.0) -> Any:
    return _engine.Material(
        _engine.TransverselyIsotropic(**FIBRED),
        density=DENSITY,
        viscosity=viscosity,
        stiffening=stiffening,
        matrix_stiffening=matrix,
    )


def stepped(mesh: Any, material: Any, fixed: Any, step: float, **parts: Any) -> Any:
    return simulation(mesh, material, fixed, step=step, lumped_mass=True, **{"scheme": CENTRAL} | parts)


def cantilever() -> tuple[Any, np.ndarray, np.ndarray]:
    """Its mesh, what is held, and a velocity that bends and stretches it by an eighth of its length."""
    mesh = block((1, 3, 1), (2e-3, 8e-3, 3e-3))
    x = np.asarray(mesh.points)
    fixed = np.repeat((x[:, 1] == 0)[:, None], 3, axis=1)
    return mesh, fixed, np.stack([60 * x[:, 1], 12 * x[:, 1], -40 * x[:, 1]], axis=1)


def leapfrog(mesh: Any, fixed: np.ndarray, law: Law, h: float, steps: int, **parts: Any) -> np.ndarray:
    """(n, 3) m: the scheme in half steps, with the law and the masses of the second algorithm."""
    force, volume = tissue_force(mesh, law)
    mass = np.zeros(len(mesh.points))
    np.add.at(mass, np.asarray(mesh.cells), DENSITY * volume[:, None] / 4)
    load = parts.get("load", 0.0)
    u = np.zeros((len(mass), 3))

    def acceleration() -> np.ndarray:
        return np.where(fixed, 0.0, (load - force(u)) / mass[:, None])

    half = np.where(fixed, 0.0, parts.get("velocity", 0.0)) + 0.5 * h * acceleration()
    for _ in range(steps):
        u = u + h * half
        if not np.abs(u).max() < 1:  # m, of a body of some mm
            return u
        half = half + h * acceleration()
    return u


def test_its_steps_are_those_of_the_leapfrog_with_the_law_written_a_second_time() -> None:
    mesh, fixed, velocity = cantilever()
    steps, h = 400, 1e-5
    expected = leapfrog(mesh, fixed, Law(stiffening=2.0, matrix=3.0), h, steps, velocity=velocity)
    assert np.abs(expected).max() > 1e-3
    run = stepped(mesh, fibred(), fixed, h, velocity=velocity)
    run.advance(steps)
    np.testing.assert_allclose(run.displacement, expected, rtol=0, atol=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize(("viscosity", "order"), [(0.0, 1), (1.5, 1), (0.5, 2)])
def test_it_is_the_motion_of_implicit_steps_to_second_order(viscosity: float, order: int) -> None:
    mesh, fixed, velocity = cantilever()
    if order == 2:
        mesh = block((1, 3, 1), (2e-3, 8e-3, 3e-3), order)
        x = np.asarray(mesh.points)
        fixed = np.repeat((x[:, 1] == 0)[:, None], 3, axis=1)
        velocity = np.stack([60 * x[:, 1], 12 * x[:, 1], -40 * x[:, 1]], axis=1)
    end, apart = 2e-3, []
    for steps in (200, 400, 800):
        one, other = (
            stepped(mesh, fibred(viscosity=viscosity), fixed, end / steps, velocity=velocity, **scheme)
            for scheme in ({}, {"scheme": _engine.Newmark()})
        )
        one.advance(steps)
        other.advance(steps)
        size = np.abs(np.asarray(other.displacement)).max()
        apart.append(np.abs(np.asarray(one.displacement) - other.displacement).max() / size)
    assert size > 3e-4
    assert 1e-7 < apart[-1] < 1e-3
    for coarse, fine in pairwise(apart):
        assert coarse / fine == pytest.approx(4, rel=0.1)


@pytest.mark.parametrize("stretched", [False, True], ids=["rest", "posture"])
def test_the_balance_of_energies_closes_to_round_off(stretched: bool) -> None:
    mesh, fixed, velocity = cantilever()
    if stretched:
        tissue = [fibred()], ["bar"], np.zeros(len(mesh.cells), dtype=np.int32)
        x = np.asarray(mesh.points)
        ends = fixed | np.repeat((x[:, 1] == x[:, 1].max())[:, None], 3, axis=1)
        held = np.zeros_like(x)
        held[:, 1] = 0.2 * x[:, 1]
        mesh = _engine.stretched(mesh, *tissue, fixed=ends, held=lambda share: share * held).mesh
        fixed = ends
        velocity = 60 * np.sin(np.pi * x[:, 1:2] / 8e-3) * [8e-3, 0, 8e-3]
    load = [] if stretched else [_engine.Load(surface="y_max", traction=(500.0, 2e3, 0.0), frequency=300.0)]
    run = stepped(mesh, fibred(viscosity=1.0), fixed, 1e-5, velocity=velocity, loads=load)
    waves = run.advance(400)
    energy = (waves["kinetic_energy"] + waves["elastic_energy"]).max()
    assert np.abs(waves["nonlinear_loss"]).max() > 1e-7 * energy
    assert waves["viscous_loss"][-1] > 0.01 * energy
    assert np.abs(waves["energy_balance_error"]).max() < 1e-12 * energy
    assert set(np.asarray(waves["force_evaluations"])) == {1}


@pytest.mark.parametrize("viscosity", [0.0, 0.5])
def test_a_free_block_that_turns_half_around_keeps_its_angular_momentum_to_round_off(
    viscosity: float,
) -> None:
    """The torque of what is objective is none; of linear tissue, which grows as it turns, it is not."""
    mesh = block((2, 1, 1), (8e-3, 4e-3, 4e-3), order=2)
    x = np.asarray(mesh.points)
    spin = np.array([20.0, 10.0, 50.0])
    middle = x - [4e-3, 2e-3, 2e-3]
    velocity = np.cross(spin, middle) + middle @ [[20.0, 0.0, 0.0], [50.0, -20.0, 0.0], [0.0, 30.0, 0.0]]
    h, free = 2e-5, np.zeros_like(x, dtype=bool)
    steps = round(np.pi / np.linalg.norm(spin) / h)
    drift, losses = [], []
    for strain in ({}, {"strain": None}):
        run = stepped(mesh, fibred(viscosity=viscosity), free, h, velocity=velocity, **strain)
        before = angular_momentum(run, mesh)
        waves = run.advance(steps)
        drift.append(np.linalg.norm(angular_momentum(run, mesh) - before) / np.linalg.norm(before))
        energy = waves["kinetic_energy"] + waves["elastic_energy"]
        losses.append(1 - energy.min() / energy[0])
    assert drift[0] < 1e-11
    assert drift[1] > 0.05
    if viscosity == 0:
        assert losses[0] < 1e-3
    assert np.abs(run.displacement).max() > 8e-3


def bar(cells: int = 8) -> tuple[Any, np.ndarray]:
    """A bar along its fibres, on rollers, so that it can be pulled evenly."""
    mesh = block((1, cells, 1), BAR)
    return mesh, np.asarray(mesh.points) == 0


def largest_step(mesh: Any, fixed: np.ndarray, law: Law, u: np.ndarray) -> float:
    """2 / w of the law's slope at u, by differences of the second algorithm's forces."""
    force, volume = tissue_force(mesh, law)
    mass = np.zeros(len(mesh.points))
    np.add.at(mass, np.asarray(mesh.cells), DENSITY * volume[:, None] / 4)
    free = np.flatnonzero(~fixed)
    slope = np.empty((len(free), len(free)))
    for column, k in enumerate(free):
        moved = np.zeros(u.size)
        moved[k] = 1e-9
        change = force(u + moved.reshape(-1, 3)) - force(u - moved.reshape(-1, 3))
        slope[:, column] = change.ravel()[free] / 2e-9
    root = np.repeat(mass, 3)[free] ** -0.5
    return float(2 / np.sqrt(np.linalg.eigvalsh(root[:, None] * (slope + slope.T) / 2 * root)[-1]))


def named(error: BaseException) -> float:
    found = re.search(r"(?:at most|<=) (\S+) s", str(error))
    assert found is not None, error
    return float(found[1])


@pytest.mark.parametrize("stretch", [0.9, 1.1, 1.25])
def test_a_start_is_taken_up_to_the_largest_step_of_where_it_is(stretch: float) -> None:
    mesh, fixed = bar()
    law, material = Law(stiffening=5.0, matrix=3.0), fibred(stiffening=5.0)
    x = np.asarray(mesh.points)
    u = x * [0.95 - 1, stretch - 1, 0.95 - 1]
    true = largest_step(mesh, fixed, law, u)
    at_rest = stepped(mesh, material, fixed, 1e-7).largest_step()
    if stretch < 1.2:
        assert true != pytest.approx(at_rest, rel=0.02)
    else:
        assert true < 0.5 * at_rest
    stepped(mesh, material, fixed, 0.985 * min(true, at_rest), displacement=u)
    if true > at_rest:
        return
    with pytest.raises(
        InvalidInput, match="not stable with longer ones where the tissue is at t = 0"
    ) as raised:
        stepped(mesh, material, fixed, 1.001 * true, displacement=u)
    assert 0.98 * true < named(raised.value) <= true


def pulled(step: float, mesh: Any, fixed: np.ndarray, **parts: Any) -> Any:
    load = [_engine.Load(surface="y_max", traction=(0.0, PULL, 0.0))]
    return stepped(mesh, fibred(stiffening=5.0), fixed, step, loads=load, **parts)


def test_a_run_whose_tissue_stiffens_beyond_its_step_is_stopped_and_a_shorter_step_is_right() -> None:
    """In the second algorithm the step that is stopped ends in nonsense, the shorter one does not."""
    mesh, fixed = bar()
    law, duration = Law(stiffening=5.0, matrix=3.0), 3e-3
    at_rest = pulled(1e-7, mesh, fixed).largest_step()
    load = np.asarray(pulled(1e-7, mesh, fixed).state()["load"]).reshape(-1, 3)
    h = 0.3 * at_rest
    run = pulled(h, mesh, fixed)
    reached, limits = [], []

    def follow() -> None:
        while True:
            run.advance(1, [])
            reached.append(np.asarray(run.displacement))
            if len(reached) % 4 == 0:
                limits.append(largest_step(mesh, fixed, law, reached[-1]))

    with pytest.raises(StepFailed) as raised:
        follow()
    assert "tissue at finite strain: its stiffness as it is deformed now, most in cell " in str(raised.value)
    assert f"the step is {h:.6g} s. Shorten the step, or take hht or newmark" in str(raised.value)
    assert len(reached) > 10
    assert min(limits) > h  # no step was taken beyond
    u, v, a = (
        np.asarray(run.state()[name]).reshape(-1, 3) for name in ("displacement", "velocity", "acceleration")
    )
    true = largest_step(mesh, fixed, law, u + h * v + 0.5 * h**2 * a)
    assert true < 1.01 * h
    assert 0.98 * true < named(raised.value) <= 1.001 * true

    fine = 0.15 * at_rest
    steps = round(duration / fine)
    run = pulled(fine, mesh, fixed)
    balance, limits = [], []
    for _ in range(steps // 10):
        waves = run.advance(10)
        balance.append(np.abs(waves["energy_balance_error"] / waves["elastic_energy"]).max())
        limits.append(largest_step(mesh, fixed, law, np.asarray(run.displacement)))
    steps = 10 * (steps // 10)
    assert fine < min(limits) < 0.4 * at_rest
    expected = leapfrog(mesh, fixed, law, fine, steps, load=load)
    np.testing.assert_allclose(run.displacement, expected, rtol=0, atol=1e-7 * np.abs(expected).max())
    assert max(balance) < 1e-11
    finer = leapfrog(mesh, fixed, law, fine / 4, 4 * steps, load=load)
    tip = np.asarray(mesh.points)[:, 1] == BAR[1]
    assert np.asarray(run.displacement)[tip, 1].mean() == pytest.approx(finer[tip, 1].mean(), rel=0.02)
    with np.errstate(all="ignore"):
        nonsense = leapfrog(mesh, fixed, law, h, round(duration / h), load=load)
    assert not np.abs(nonsense).max() < 1


def explicit(scene: plica.Scene, step: float, **changes: Any) -> plica.Scene:
    given = {"time.scheme": "central_differences", "time.step": step}
    return scene.replace({**given, "time.duration": 1000 * step, "strain": "finite", **changes})


def explicit_voice(**changes: Any) -> plica.Scene:
    """Folds at a posture, of tissue that stiffens, that fly at each other in the flow."""
    given = {"mesh.order": 1, "contact": None, "initial": {"opening_velocity": -1.0}}
    return explicit(voice(posture={"elongation": 0.05}, **STIFFENS), 3e-7, **given, **changes)


@pytest.mark.parametrize("kind", ["flow", "contact"])
def test_it_has_the_same_bits_resumed_and_with_two_threads(colliding: plica.Scene, kind: str) -> None:
    penalty = {"contact.penalty": {"stiffness": 20.0}, "contact.multipliers": None}
    fast = {"initial.velocity": {"a": (0.5, 0.0, 0.0), "b": (-0.5, 0.0, 0.0)}}
    scene = explicit_voice() if kind == "flow" else explicit(colliding, 2e-5, **penalty, **fast)
    first, through = resumed_on_two_threads(scene, 20, 80)
    energy = (through["kinetic_energy"] + through["elastic_energy"]).max()
    assert np.abs(first["nonlinear_loss"]).max() > 0
    assert np.abs(through["energy_balance_error"]).max() < 1e-11 * energy
    if kind == "contact":
        assert through["contact_rows"].max() > 0
        assert through["strain_largest"].max() > 0.05


def test_what_contact_adds_to_the_stiffness_of_now_is_told_as_its_own(colliding: plica.Scene) -> None:
    """What is closed counts beside the tissue: a penalty by volume has no bound beforehand."""
    fast = {"initial.velocity": {"a": (0.5, 0.0, 0.0), "b": (-0.5, 0.0, 0.0)}}
    soft, stiff = (
        explicit(
            colliding,
            1e-5,
            **{"contact.volume_penalty": {"kappa": kappa}, "contact.multipliers": None},
            **fast,
        )
        for kappa in (1e9, 1e13)
    )
    assert plica.build_simulation(soft).advance(60)["contact_rows"].max() > 0
    run = plica.build_simulation(stiff)
    with pytest.raises(
        StepFailed, match=r"Contact: its stiffness at node \d+ asks for steps of at most "
    ) as raised:
        run.advance(60)
    assert 0 < named(raised.value) < 1e-5


@pytest.mark.parametrize("symmetry", ["half", "quarter"])
def test_a_part_of_a_symmetric_voice_moves_as_the_whole(symmetry: str) -> None:
    whole, part = (plica.build_simulation(explicit_voice(symmetry=of)) for of in (None, symmetry))
    one, other = whole.advance(100), part.advance(100)
    size = np.abs(np.asarray(whole.displacement)).max()
    np.testing.assert_allclose(part.displacement, whole.displacement, rtol=0, atol=1e-9 * size)
    np.testing.assert_allclose(other["elastic_energy"], one["elastic_energy"], rtol=1e-8)
    assert part.largest_step() > 0.999 * whole.largest_step()  # fewer motions are possible

"""Tissue at finite strain in time: closed forms, a second algorithm, conservation, and what must not depend
on how a run is cut."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import curve_fit, fsolve

import plica
from plica import SolveFailed, StepFailed, _engine
from plica.identify.model.model import require_linear
from stretched_bodies import (
    DENSITY,
    FIBRED,
    STIFFENS,
    TRAPEZOIDAL,
    Law,
    angular_momentum,
    block,
    consistent_mass,
    resumed_on_two_threads,
    simulation,
    tissue_force,
    voice,
)


def test_a_pulled_bar_comes_to_rest_where_its_law_says() -> None:
    """Nominal stress lambda_y T along the fibre under a dead load, none across it."""
    size, pull, law = (1e-3, 8e-3, 1e-3), 20e3, Law(stiffening=2.0, matrix=3.0)
    for order in (1, 2):
        mesh = block((1, 4, 1), size, order)
        x = np.asarray(mesh.points)
        material = _engine.Material(
            _engine.TransverselyIsotropic(**FIBRED),
            density=DENSITY,
            viscosity=30.0,
            stiffening=2.0,
            matrix_stiffening=3.0,
        )
        load = [_engine.Load(surface="y_max", traction=(0.0, pull, 0.0))]
        run = simulation(mesh, material, x == 0, step=5e-4, loads=load, scheme=_engine.HilberHughesTaylor())
        run.advance(600)

        def left(stretch: np.ndarray) -> np.ndarray:
            P = law.stress(np.diag([stretch[0], stretch[1], stretch[0]]))
            return np.array([P[0, 0], P[1, 1] - pull])

        across, along = fsolve(left, [0.9, 1.3], xtol=1e-13)
        assert along > 1.2
        np.testing.assert_allclose(run.displacement, (np.array([across, along, across]) - 1) * x, atol=1e-9)
        assert np.abs(run.velocity).max() < 1e-9


def turning(step: float, turns: float = 0.5, **parts: Any) -> Any:
    """A free block of viscous tissue that spins about an axis through its middle."""
    mesh = block((2, 1, 1), (8e-3, 4e-3, 4e-3), order=2)
    x = np.asarray(mesh.points)
    spin = np.array([20.0, 10.0, 50.0])
    material = _engine.Material(_engine.TransverselyIsotropic(**FIBRED), density=DENSITY, viscosity=0.5)
    velocity = np.cross(spin, x - np.array([4e-3, 2e-3, 2e-3]))
    run = simulation(mesh, material, np.zeros_like(x, dtype=bool), step=step, velocity=velocity, **parts)
    waves = run.advance(round(turns * 2 * np.pi / np.linalg.norm(spin) / step))
    return run, waves, mesh


def test_a_block_that_turns_keeps_its_momentum_and_is_hardly_strained() -> None:
    drift, loose = [], {"strain": _engine.FiniteStrain(tolerance=1e-6)}
    for step in (5e-4, 2.5e-4):
        start, _, mesh = turning(step, 0.0)
        run, waves, _ = turning(step, **loose)
        before = angular_momentum(start, mesh)
        drift.append(np.linalg.norm(angular_momentum(run, mesh) - before) / np.linalg.norm(before))
        kinetic = waves["kinetic_energy"].max()
        assert waves["elastic_energy"].max() < 0.01 * kinetic  # what holds it together: rho (spin size)^2 / E
        assert np.abs(waves["viscous_loss"]).max() < 0.005 * kinetic  # of the oscillation about that
        assert np.abs(run.displacement).max() > 8e-3
        assert waves["strain_999"].max() < 0.1  # Green and Lagrange's; the small strain of half a turn is 2
        assert np.abs(waves["energy_balance_error"]).max() < 1e-9 * kinetic
    assert drift[1] < 1e-4
    assert drift[1] == pytest.approx(drift[0] / 4, rel=0.1)
    linear = turning(2.5e-4, strain=None)[0]
    for moved, longer in ((run, 1.0), (linear, 2.0)):  # linear tissue grows as it turns, along straight lines
        x = np.asarray(mesh.points) + moved.displacement
        rest = np.ptp(np.asarray(mesh.points), axis=0)
        diagonal = np.linalg.norm(x[np.argmax(mesh.points @ rest)] - x[np.argmin(mesh.points @ rest)])
        ratio = diagonal / np.linalg.norm(rest)
        assert ratio == pytest.approx(1, abs=0.02) if longer == 1 else ratio > longer


def stretched_bar(stretch: float, cells: int) -> tuple[Any, np.ndarray]:
    """A bar at a posture along its fibres, whose nodes then move along x alone; held at both ends."""
    length, width = 16e-3, 1e-3
    mesh = block((1, cells, 1), (width, length, width))
    x = np.asarray(mesh.points)
    fixed = x == 0
    fixed[:, 1] |= x[:, 1] == length
    held = np.zeros_like(x)
    held[:, 1] = (stretch - 1) * x[:, 1]
    material = _engine.Material(_engine.TransverselyIsotropic(**FIBRED), density=DENSITY, stiffening=1.0)
    tissue = [material], ["bar"], np.zeros(len(mesh.cells), dtype=np.int32)
    found = _engine.stretched(mesh, *tissue, fixed=fixed, held=lambda share: share * held)
    fixed = np.ones_like(fixed)
    fixed[:, 0] = (x[:, 1] == 0) | (x[:, 1] == length)
    return found.mesh, fixed


def standing_wave(stretch: float, amplitude: float, step: float, steps: int, **parts: Any) -> np.ndarray:
    """Amplitude of the lowest mode in time, m."""
    mesh, fixed = stretched_bar(stretch, 24)
    rest = np.asarray(mesh.rest)
    shape = np.sin(np.pi * rest[:, 1] / 16e-3)
    displacement = np.zeros_like(rest)
    displacement[:, 0] = amplitude * shape
    material = _engine.Material(_engine.TransverselyIsotropic(**FIBRED), density=DENSITY, stiffening=1.0)
    run = simulation(mesh, material, fixed, step=step, displacement=displacement, **parts)
    found = [amplitude]
    for _ in range(steps):
        run.advance(1, [])
        found.append(float(run.displacement[:, 0] @ shape / (shape @ shape)))
    return np.array(found)


@pytest.mark.parametrize("stretch", [1.0, 1.3])
def test_small_motion_of_a_stretched_bar_is_the_string_law(stretch: float) -> None:
    """f_1 of linear cells with shear, as the trapezoidal rule has it: tan(w' h / 2) = w h / 2."""
    law, cells = Law(stiffening=1.0), 24
    q = (stretch**2 - 1) / 2

    def pull(across: np.ndarray) -> np.ndarray:
        return np.array([law.stress(np.diag([across[0], stretch, across[0]]))[0, 0]])

    across = float(fsolve(pull, [0.95], xtol=1e-14)[0])
    modulus = law.mu + law.shear * across**2 + 2 * law.beta * np.log(stretch * across**2) + law.e * q
    modulus += law.along * q * np.expm1(4 * law.k * q**2)
    angle = np.pi / cells
    square = 6 * (1 - np.cos(angle)) / (2 + np.cos(angle)) * modulus / DENSITY * (cells / 16e-3) ** 2
    step, steps = 1e-4, 400
    slowed = 2 / step * np.arctan(np.sqrt(square) * step / 2)
    finite, linear = (
        standing_wave(stretch, 1e-8, step, steps, **how) / 1e-8 for how in ({}, {"strain": None})
    )
    assert slowed * step * steps > 6 * np.pi  # three periods
    time = step * np.arange(steps + 1)
    found = [curve_fit(lambda t, w: np.cos(w * t), time, wave, slowed)[0][0] for wave in (finite, linear)]
    assert found[0] == pytest.approx(slowed, rel=2e-4)  # cells of a bar do not quite move in rows
    assert found[0] == pytest.approx(found[1], rel=1e-6)
    np.testing.assert_allclose(finite, linear, atol=1e-5)


def second_algorithm(mesh: Any, fixed: np.ndarray, velocity: np.ndarray, end: float) -> np.ndarray:
    """Linear tetrahedra of the law with consistent mass, integrated by DOP853 to 1e-10."""
    x = np.asarray(mesh.points)
    force, volume = tissue_force(mesh, Law(stiffening=2.0, matrix=3.0))
    mass = consistent_mass(mesh, volume)
    free = ~fixed

    solvers = [np.linalg.inv(mass[np.ix_(free[:, k], free[:, k])]) for k in range(3)]

    @np.errstate(invalid="ignore", over="ignore")  # a trial step may turn cells inside out
    def rate(_: float, state: np.ndarray) -> np.ndarray:
        u, v = state.reshape(2, -1, 3)
        f, a = force(u), np.zeros_like(u)
        for k in range(3):
            a[free[:, k], k] = -solvers[k] @ f[free[:, k], k]
        return np.concatenate([v.ravel(), a.ravel()])

    start = np.concatenate([np.zeros(x.size), np.where(free, velocity, 0).ravel()])
    ode = solve_ivp(rate, (0, end), start, method="DOP853", rtol=1e-10, atol=1e-13, max_step=end / 400)
    return ode.y[: x.size, -1].reshape(-1, 3)


@pytest.mark.parametrize(
    "scheme", [TRAPEZOIDAL, _engine.HilberHughesTaylor(alpha=-0.1)], ids=["newmark", "hht"]
)
def test_large_motion_is_that_of_a_second_algorithm_to_second_order(scheme: Any) -> None:
    mesh = block((1, 3, 1), (2e-3, 8e-3, 3e-3))
    x = np.asarray(mesh.points)
    fixed = np.repeat((x[:, 1] == 0)[:, None], 3, axis=1)
    velocity = np.stack([60 * x[:, 1], 12 * x[:, 1], -40 * x[:, 1]], axis=1)
    end = 4e-3
    exact = second_algorithm(mesh, fixed, velocity, end)
    assert np.abs(exact).max() > 1e-3  # an eighth of the length
    material = _engine.Material(
        _engine.TransverselyIsotropic(**FIBRED), density=DENSITY, stiffening=2.0, matrix_stiffening=3.0
    )
    errors = []
    for steps in (200, 400, 800):
        run = simulation(mesh, material, fixed, step=end / steps, velocity=velocity, scheme=scheme)
        run.advance(steps)
        errors.append(np.abs(np.asarray(run.displacement) - exact).max())
    linear = simulation(mesh, material, fixed, step=end / 800, velocity=velocity, strain=None)
    linear.advance(800)
    assert np.abs(np.asarray(linear.displacement) - exact).max() > 0.1 * np.abs(exact).max()
    assert errors[-1] < 2e-3 * np.abs(exact).max()
    for coarse, fine in pairwise(errors):
        assert coarse / fine == pytest.approx(4, rel=0.15)


@pytest.mark.parametrize("model", ["viscous_slit", "bernoulli"])
def test_flow_contact_and_balance_of_energies(model: str) -> None:
    run = plica.build_simulation(voice(**{"airflow.model": model}))
    waves = run.advance(60)
    assert waves["flow_stopped"].any() == (model == "bernoulli")  # by contact
    assert waves["coupling_converged"].all()
    assert waves["contact_rows"].max() > 0
    assert waves["flow"].max() > 0
    energy = (waves["kinetic_energy"] + waves["elastic_energy"]).max()
    assert np.abs(waves["energy_balance_error"]).max() < 1e-6 * energy
    assert 0 < np.abs(waves["nonlinear_loss"]).max() < 0.05 * energy
    assert waves["force_evaluations"].min() >= 2
    assert "strain_neglected" not in waves


@pytest.mark.parametrize("changes", [{}, STIFFENS], ids=["plain", "stiffens"])
def test_a_part_of_a_symmetric_voice_moves_as_the_whole(changes: dict[str, Any]) -> None:
    tight = {"strain": {"finite": {"tolerance": 1e-9}}, "contact.tolerance": 1e-6, "solver.tolerance": 1e-11}
    tight["airflow.coupling"] = {"iterated": {"tolerance": 1e-9}}
    whole, quarter = (
        plica.build_simulation(voice(symmetry=part, **tight, **changes)) for part in (None, "quarter")
    )
    one, other = whole.advance(10), quarter.advance(10)
    assert one["contact_rows"].max() > 0
    size = np.abs(np.asarray(whole.displacement)).max()
    np.testing.assert_allclose(quarter.displacement, whole.displacement, atol=1e-7 * size)
    np.testing.assert_allclose(other["elastic_energy"], one["elastic_energy"], rtol=1e-6)


@pytest.mark.parametrize(
    "changes",
    [{}, {"posture": {"elongation": 0.05}, "symmetry": "quarter"}, STIFFENS],
    ids=["rest", "posture", "stiffens"],
)
def test_the_same_bits_resumed_and_with_two_threads(changes: dict[str, Any]) -> None:
    resumed_on_two_threads(voice(**changes), 20, 10)


def refused(call: Callable[[], object], *texts: str) -> None:
    with pytest.raises((SolveFailed, plica.InvalidInput)) as caught:
        call()
    for text in texts:
        assert text in str(caught.value)


def test_what_does_not_settle_or_has_no_force_says_so() -> None:
    run = plica.build_simulation(voice(strain={"finite": {"max_iterations": 1}}))
    with pytest.raises(StepFailed, match=r"out of balance by .* after 1 iterations, most at"):
        run.advance(5)
    mesh = block((1, 2, 1), (1e-3, 2e-3, 1e-3))
    x = np.asarray(mesh.points)
    material = _engine.Material(_engine.Isotropic(E=1e3, nu=0.3), density=DENSITY)
    folded = np.where(x[:, 1:2] == 2e-3, [0.0, -3e-3, 0.0], 0.0)
    refused(
        lambda: simulation(mesh, material, x == 0, displacement=folded),
        "displacement at t = 0: cell",
        "is inside out; must keep its orientation",
    )
    transverse = _engine.Material(_engine.TransverselyIsotropic(**FIBRED, mu=500.0), density=DENSITY)
    refused(
        lambda: simulation(mesh, transverse, x == 0),
        "Stretched tissue: mu = 500 Pa",
        "isotropic across its fibre",
    )
    state = simulation(mesh, material, x == 0).state()
    refused(lambda: simulation(mesh, material, x == 0).renewed(state), "renewed with strain = finite")
    refused(
        lambda: simulation(mesh, material, x == 0, strain=None).restore(state), "belongs to another scene"
    )


def test_what_rests_on_one_stiffness_refuses_it() -> None:
    scene = voice()
    refused(lambda: plica.growth(scene, 100.0), "strain is given; must be left out: small motion")
    refused(
        lambda: require_linear(scene), "strain is given; must be left out", 'without = ["strain"], softer'
    )
    printed = voice().replace({"tissue": "thesis"})
    refused(
        lambda: plica.build_simulation(printed),
        "tissue.body.mu_transverse = ",
        "must be left out, or ",
        "with strain: stretched tissue is isotropic across its fibre",
    )
    linear = scene.replace({"strain": None})
    assert plica.eigenmodes(scene, 2).frequency == pytest.approx(
        plica.eigenmodes(linear, 2).frequency, rel=1e-12
    )


@pytest.mark.parametrize(("coupling", "order"), [("lagged", 1), ("extrapolated", 3)])
def test_couplings_that_do_not_iterate_differ_from_one_that_does_by_their_order(
    coupling: str, order: int
) -> None:
    """A step's extrapolated positions are off by h^3."""
    given = {"strain": {"finite": {"tolerance": 1e-9}}, "solver.tolerance": 1e-11, "contact": None}
    given |= {"mesh.order": 1, "symmetry": "quarter", "initial": {"opening_velocity": -0.5}, **STIFFENS}
    apart = []
    for steps in (20, 40, 80):
        one, other = (
            plica.build_simulation(voice(**given, **{"time.step": 1e-3 / steps, "airflow.coupling": of}))
            for of in (coupling, {"iterated": {"tolerance": 1e-9}})
        )
        waves = one.advance(steps)
        other.advance(steps)
        size = np.abs(np.asarray(other.displacement)).max()
        apart.append(np.abs(np.asarray(one.displacement) - other.displacement).max() / size)
        assert waves["force_evaluations"].max() > 2
        energy = (waves["kinetic_energy"] + waves["elastic_energy"]).max()
        assert np.abs(waves["energy_balance_error"]).max() < 1e-7 * energy
    assert apart[-1] > 1e-7
    for coarse, fine in pairwise(apart):
        assert coarse / fine == pytest.approx(2**order, rel=0.2)

"""The explicit scheme: its order, its largest step, what it keeps, and what it refuses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import eigsh, spsolve

from plica import _engine as engine
from plica.errors import InvalidInput, SolveFailed
from plica.verify.bodies.bars import PROBLEMS
from plica.verify.bodies.body import Body, block
from plica.verify.tissue.modes import exact_shear, per_cell, shear_block

CENTRAL = engine.CentralDifferences()
SIZE = (0.02, 0.01, 0.01)


def held_block(viscosity: float, order: int = 1, nu: float = 0.3) -> Body:
    mesh = block(SIZE, (4, 2, 2), order)
    fixed = np.zeros((len(mesh.points), 3), bool)
    return Body(mesh, engine.Material(engine.Isotropic(20e3, nu), 1040.0, viscosity), fixed).hold("x_min")


def stepped(body: Body, step: float, **parts: Any) -> engine.Simulation:
    return body.simulation(scheme=CENTRAL, step=step, lumped_mass=True, **parts)


def matrices(body: Body) -> tuple[Any, Any, Any]:
    """M, C and K of the free unknowns with a lumped mass; C is zero without viscosity."""
    probe = body.simulation(scheme=engine.Newmark(), step=1e-4, lumped_mass=True)
    M, K = body.on_free(probe.mass), body.on_free(probe.stiffness)
    return M, 0 * K if probe.viscosity is None else body.on_free(probe.viscosity), K


def eigenvalue(body: Body, h: float) -> float:
    """The largest of M^-1 (h C + h^2 / 4 K), by ARPACK."""
    M, C, K = matrices(body)
    scale = diags_array(M.diagonal() ** -0.5)
    found = eigsh(scale @ (h * C + 0.25 * h**2 * K) @ scale, k=1, which="LA", return_eigenvectors=False)
    return float(found[0])


def leapfrog(body: Body, start: Any, h: float, steps: int) -> Any:
    """The scheme written out in half steps, without loads and from rest: u after so many steps."""
    M, C, K = matrices(body)
    mass = M.diagonal()
    u = start.copy()
    a = -(K @ u) / mass
    before = np.zeros_like(u)
    half = 0.5 * h * a
    for k in range(steps):
        u = u + h * half
        ahead = 1.5 * half - 0.5 * before if k else h * a
        a = -(K @ u + C @ ahead) / mass
        before, half = half, half + h * a
    return u


@pytest.mark.parametrize("viscosity", [0.0, 1.5])
def test_its_steps_are_those_of_the_leapfrog_with_extrapolated_viscosity(viscosity: float) -> None:
    body = held_block(viscosity)
    start = 1e-4 * np.random.default_rng(1).standard_normal(len(body.free))
    simulation = stepped(body, 5e-5, displacement=body.field(start))
    simulation.advance(60)
    expected = leapfrog(body, start, 5e-5, 60)
    assert np.abs(expected - start).max() > 1e-5
    np.testing.assert_allclose(simulation.displacement.ravel()[body.free], expected, rtol=0, atol=1e-15)


def test_displacement_velocity_and_acceleration_are_of_order_2_on_viscous_forced_motion() -> None:
    body = held_block(1.5)
    load = engine.Load(surface="x_max", traction=(30.0, 20.0, -10.0), frequency=60.0)
    M, C, K = matrices(body)
    force = np.asarray(stepped(body, 1e-5, loads=[load]).state()["load"])[body.free]
    w, end = 2 * np.pi * 60.0, 0.012
    z = spsolve((K + 1j * w * C - w**2 * M).tocsc(), force)  # u = Re z exp(i w t), exact for the mesh
    errors = []
    for steps in (240, 480):
        simulation = stepped(
            body,
            end / steps,
            loads=[load],
            displacement=body.field(z.real),
            velocity=body.field((1j * w * z).real),
        )
        simulation.advance(steps)
        exact = z * np.exp(1j * w * end)
        found = (simulation.displacement, simulation.velocity, simulation.acceleration)
        errors.append(
            [
                np.linalg.norm(value.ravel()[body.free] - ((1j * w) ** k * exact).real)
                / np.linalg.norm(w**k * z)
                for k, value in enumerate(found)
            ]
        )
    orders = np.log2(np.divide(*errors))
    assert np.all(np.array(errors[0]) > 1e-6)
    assert np.all(np.abs(orders - 2) < 0.1), orders


def test_a_mode_swings_with_the_frequency_of_the_closed_form() -> None:
    body = held_block(0.0)
    M, _, K = matrices(body)
    value, mode = eigsh(K, k=1, M=M, sigma=0.0)
    h = 1.5 / np.sqrt(value[0])
    h /= np.ceil(h / stepped(body, 1e-6).largest_step())
    angle = 2 * np.arcsin(0.5 * h * np.sqrt(value[0]))
    start = 1e-4 * mode[:, 0] / np.abs(mode).max()
    simulation = stepped(body, h, displacement=body.field(start))
    simulation.advance(100)
    expected = np.cos(100 * angle) * start
    np.testing.assert_allclose(simulation.displacement.ravel()[body.free], expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("viscosity", "order", "nu"),
    [(0.0, 1, 0.3), (1.5, 1, 0.3), (0.4, 2, 0.3), (0.4, 1, 0.49), (200.0, 1, 0.3)],
)
def test_the_largest_step_is_just_below_that_of_the_eigenvalue(
    viscosity: float, order: int, nu: float
) -> None:
    body = held_block(viscosity, order, nu)
    found = eigenvalue(body, stepped(body, 1e-8).largest_step())
    assert 0.97 < found <= 1.0


@pytest.mark.parametrize("viscosity", [0.0, 0.5])
def test_motion_at_the_largest_step_stays_and_just_above_the_true_limit_grows(viscosity: float) -> None:
    body = held_block(viscosity, nu=0.45)
    start = 1e-4 * np.random.default_rng(2).standard_normal(len(body.free))
    h = stepped(body, 1e-8).largest_step()
    simulation = stepped(body, 0.999 * h, displacement=body.field(start))
    simulation.advance(3000)
    assert np.abs(simulation.displacement).max() < 10 * np.abs(start).max()
    true = h
    while eigenvalue(body, true) < 1:
        true *= 1.001
    with np.errstate(over="ignore", invalid="ignore"):
        grown = np.abs(leapfrog(body, start, 1.03 * true, 1500)).max()
    assert not grown < 1e3 * np.abs(start).max()


def test_a_step_above_the_limit_is_refused_with_the_largest_that_is_not() -> None:
    body = held_block(0.5)
    largest = stepped(body, 1e-6).largest_step()
    with pytest.raises(
        InvalidInput, match=r"step = 0\.001 s; must be <= \S+ s\. Central differences"
    ) as caught:
        stepped(body, 1e-3)
    named = float(str(caught.value).split("<= ")[1].split(" s")[0])
    assert named == pytest.approx(largest, rel=1e-5)
    stepped(body, 0.999 * largest)
    with pytest.raises(InvalidInput, match="Central differences are not stable"):
        stepped(body, 1.01 * largest)
    assert body.simulation(scheme=engine.Newmark(), step=1e-3).largest_step() is None


def test_energy_is_lent_and_given_back_and_the_ledger_closes() -> None:
    body = held_block(0.0)
    start = 1e-4 * np.random.default_rng(3).standard_normal(len(body.free))
    simulation = stepped(body, 5e-5, displacement=body.field(start))
    M, _, _ = matrices(body)

    def kept() -> float:
        state = simulation.state()
        a = np.asarray(state["acceleration"])[body.free]
        return float(state["kinetic"] + state["elastic"] - 5e-5**2 / 8 * a @ (M @ a))

    before = kept()
    waves = simulation.advance(200)
    assert kept() == pytest.approx(before, rel=1e-11)
    assert np.abs(waves["numerical_loss"]).max() > 1e-3 * before
    assert np.abs(waves["energy_balance_error"]).max() < 1e-12 * before


def bars(stiffness: float, courant: float) -> tuple[Any, dict[str, Any]]:
    """R3, equal bars that meet: the problem, and waveforms until they have parted; energies over the start's.

    `stiffness` in N/m a node and m of edge; the step is `courant` times that of a wave through an edge.
    """
    problem = PROBLEMS["R3"](40)
    body, parts = problem.build(problem.bar)
    parts.pop("measured")
    penalty = engine.Penalty(stiffness=stiffness * problem.bar.edge)
    contact = engine.Contact(airway=parts.pop("airway"), enforcement=penalty)
    simulation = stepped(body, courant * problem.bar.step, contact=contact, **parts)
    found = simulation.advance(round(problem.duration / problem.bar.step / courant))
    initial = simulation.state()["initial"]
    found["energy"] = (found["kinetic_energy"] + found["elastic_energy"]) / initial
    found["energy_balance_error"] /= initial
    return problem, found


def test_equal_bars_exchange_velocities_in_penalty_contact() -> None:
    problem, found = bars(5e3, 0.25)
    step = 0.25 * problem.bar.step
    pressure = np.abs(found["contact_force_first"][:, 0]) / problem.bar.edge**2
    exact = problem.exact.pressure(np.array([0.5 * problem.exact.end]))[0]
    middle = np.abs(found["time"] / problem.exact.end - 0.5) < 0.25
    assert pressure[middle].mean() == pytest.approx(exact, rel=0.005)
    # Of 40 elements and a penalty that lets the waves through a little late.
    assert (pressure > 0).sum() * step == pytest.approx(problem.exact.end, rel=0.03)
    assert pressure.sum() * step == pytest.approx(problem.exact.end * exact, rel=0.01)
    assert found["energy"].min() < 0.99  # lent to the penalty
    assert found["energy"][-1] == pytest.approx(1, rel=1e-3)
    assert np.abs(found["energy_balance_error"]).max() < 1e-12


def test_energy_that_a_stiff_penalty_makes_falls_with_the_step() -> None:
    made = []
    for courant in (0.25, 0.125):
        _, found = bars(20e3, courant)
        made.append(abs(found["energy"][-1] - 1))
    assert made[0] > 0.02  # just below its largest step
    assert made[1] < 0.25 * made[0]


def test_a_penalty_that_is_too_stiff_for_the_step_is_refused_beforehand() -> None:
    with pytest.raises(InvalidInput, match=r"step = \S+ s; must be <= "):
        bars(20e6, 0.25)


def test_the_largest_step_with_a_penalty_is_just_below_that_of_faces_that_it_joins() -> None:
    problem = PROBLEMS["R3"](12)
    body, parts = problem.build(problem.bar)
    own, stiffness = (
        parts.pop("measured"),
        20e6 * problem.bar.edge,
    )  # N/m a node: most of the eigenvalue is its
    contact = engine.Contact(airway=parts.pop("airway"), enforcement=engine.Penalty(stiffness=stiffness))
    h = stepped(body, 1e-9, contact=contact, **parts).largest_step()
    M, _, K = matrices(body)
    met = np.abs(np.asarray(body.mesh.points)[:, 0]) < 1e-9 * problem.bar.length
    gaps = np.zeros(
        (body.fixed.size, 4)
    )  # of the nodes that face each other, in the same order on both faces
    gaps[3 * np.flatnonzero(met & own), range(4)] = 1
    gaps[3 * np.flatnonzero(met & ~own), range(4)] = -1
    joined = K.toarray() + stiffness * gaps[body.free] @ gaps[body.free].T
    root = M.diagonal() ** -0.5
    found = 0.25 * h**2 * np.linalg.eigvalsh(root[:, None] * joined * root)[-1]
    assert 0.97 < found <= 1.0


def volume_gaps(body: Body, airway: Any) -> Any:
    """(rows, 3 n) how a node less the mean of its face moves, of the airway tetrahedra that have both"""
    first, rows = np.unique(airway.first), []
    for tet in airway.tets:
        one, *others = sorted((tet[np.isin(tet, first)], tet[~np.isin(tet, first)]), key=len)
        if len(one) == 1:
            row = np.zeros(body.fixed.size)
            row[3 * one], row[3 * others[0]] = 1, -1 / 3
            rows.append(row)
    return np.array(rows)


def test_a_volume_penalty_is_taken_up_to_the_bound_of_what_is_closed_and_no_further() -> None:
    problem = PROBLEMS["R3"](10)
    body, parts = problem.build(problem.bar)
    parts.pop("measured")
    airway, h = parts.pop("airway"), 0.25 * problem.bar.step
    M, _, K = matrices(body)
    gaps, of_unit = volume_gaps(body, airway)[:, body.free], problem.bar.edge**2 / 24  # kappa area / 12
    diagonal = np.abs(gaps).sum(axis=1) @ np.abs(gaps) / M.diagonal()
    limit = (1 - eigenvalue(body, h)) / (0.25 * h**2 * of_unit * diagonal.max())
    root = M.diagonal() ** -0.5
    joined = K.toarray() + limit * of_unit * gaps.T @ gaps
    assert 0.6 < 0.25 * h**2 * np.linalg.eigvalsh(root[:, None] * joined * root)[-1] < 1  # it is a bound

    def meeting(kappa: float) -> engine.Simulation:
        contact = engine.Contact(airway=airway, enforcement=engine.VolumePenalty(kappa=kappa))
        return stepped(body, h, contact=contact, **parts)

    below = meeting(0.97 * limit)  # the engine's eigenvalue of K is up to 1 % above
    waves = below.advance(round(problem.duration / h))
    assert waves["contact_rows"].max() == len(gaps)
    assert (waves["contact_rows"] > 0).sum() > 30
    energy = waves["kinetic_energy"] + waves["elastic_energy"]
    assert energy.max() < 1.2 * below.state()["initial"]  # R3's gain near a penalty's largest step
    with pytest.raises(
        SolveFailed, match=r"its stiffness at node \d+ asks for steps of at most (\S+) s"
    ) as raised:
        meeting(1.03 * limit).advance(1)
    named = float(str(raised.value).split("at most ")[1].split(" s")[0])
    assert 0.98 * h < named < h


@pytest.mark.parametrize(
    ("parts", "contact", "message"),
    [
        ({"lumped_mass": False}, {}, "with a consistent mass; must be a lumped one"),
        ({}, {"enforcement": engine.Multipliers()}, "with contact that is solved for; must be a penalty"),
        ({}, {"enforcement": engine.Nitsche()}, "with contact that is solved for; must be a penalty"),
        ({}, {"enforcement": engine.Augmented()}, "with contact that is solved for; must be a penalty"),
        ({}, {"enforcement": engine.Penalty(), "friction": 0.3}, "with friction; must be left out"),
        (
            {},
            {"enforcement": engine.Penalty(), "surface_mass": "redistributed"},
            "with massless contact nodes; must be nodes that have mass",
        ),
    ],
)
def test_what_takes_a_solve_is_refused(parts: dict[str, Any], contact: dict[str, Any], message: str) -> None:
    problem = PROBLEMS["R3"](12)
    body, given = problem.build(problem.bar)
    given.pop("measured")
    airway = given.pop("airway")
    if contact:
        given["contact"] = engine.Contact(airway=airway, **contact)
    with pytest.raises(InvalidInput, match=f"^Simulation: central differences {message}"):
        body.simulation(**{"scheme": CENTRAL, "step": 1e-6, "lumped_mass": True, **given, **parts})


def test_nothing_is_factorised() -> None:
    simulation = stepped(held_block(0.5), 1e-6)
    assert simulation.info()["linear_solver"] == "none"
    assert simulation.state()["past_images"].size == 0


def test_the_mass_is_diagonal() -> None:
    body = held_block(0.0, order=2)
    mass = csr_array(stepped(body, 1e-6).mass, shape=(body.fixed.size,) * 2)
    assert abs(mass - diags_array(mass.diagonal())).sum() == 0
    assert mass.diagonal().min() > 0


@pytest.mark.slow
@pytest.mark.parametrize(("order", "cells"), [(1, 4), (2, 2)])
def test_a_lumped_mass_takes_the_shear_mode_below_the_exact_one_to_second_order(
    order: int, cells: int
) -> None:
    """R7, whose errors with a consistent mass are rows of `plica verify`."""
    errors, exact = [], exact_shear(1, 0)
    for finer in (cells, 2 * cells):
        body = shear_block(order, finer)
        M, _, K = matrices(body)
        x = body.mesh.points[:, 0]
        shape = np.zeros((len(x), 3))
        shape[:, 1] = np.sin(0.5 * np.pi * x / np.ptp(x))
        squares, modes = eigsh(K, k=12, M=M, sigma=exact**2)
        own = np.argmax(np.abs(modes.T @ (M @ shape.ravel()[body.free])))
        errors.append(np.sqrt(squares[own]) / exact - 1)
    assert max(errors) < 0
    next_term = np.log2(1 + per_cell(cells, 1, 0) ** 2)  # of the error, on the coarser mesh
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=next_term)

"""The energy balance by formulas of its own (R13), and what free bodies keep (R10)."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine as engine
from plica.verify.bodies.body import SCHEMES, Body, free_block
from plica.verify.case import Case, Check, zero

__all__ = ["CASES"]

Array = NDArray[np.float64]

SIZE, DIVISIONS = (0.02, 0.01, 0.01), (4, 2, 2)  # m
E, NU, ETA, DENSITY = 20e3, 0.3, 1.0, 1040.0
TRACTION, FREQUENCY, PHASE = (30.0, 20.0, -10.0), 60.0, 0.4  # Pa, Hz, rad
STEP, STEPS = 4e-4, 80  # s
SOLVES = 1e-13
BEGIN = 2  # step from which on the formulas hold; for those before: docs/theory/time.md, "The first step"
LEDGERS = {"trapezoidal": "trapezoidal", "hht": "HHT(-0.3)", "newmark": "Newmark(1, 3/2)"}


def block() -> Body:
    law = engine.Isotropic(E, NU)
    return free_block(law, SIZE, DIVISIONS, 1, density=DENSITY, viscosity=ETA)


def nodal_load(body: Body) -> Array:
    """(3 n) N: a third of each loaded triangle's area times the traction, at each of its corners."""
    x, faces = np.asarray(body.mesh.points), np.asarray(body.mesh.surfaces["x_max"])
    a, b, c = (x[faces[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    force = np.zeros(x.shape)
    for k in range(3):
        np.add.at(force, faces[:, k], (area / 3)[:, None] * TRACTION)
    return force.ravel()


def coefficients(scheme: Any) -> tuple[float, float, float]:
    """alpha, beta, gamma."""
    if isinstance(scheme, engine.Newmark):
        return 0.0, scheme.beta, scheme.gamma
    return scheme.alpha, (1 - scheme.alpha) ** 2 / 4, 0.5 - scheme.alpha


def ledger(name: str) -> Iterator[Check]:
    """Works and losses of a viscous block under an oscillating load, from its states."""
    scheme = SCHEMES[LEDGERS[name]]
    body = block().hold("x_min")
    velocity = np.zeros(body.fixed.shape)
    velocity[:, 2] = 0.02 * np.asarray(body.mesh.points)[:, 0] / SIZE[0]
    simulation = body.simulation(
        scheme=scheme,
        step=STEP,
        solver_tolerance=SOLVES,
        loads=[engine.Load(surface="x_max", traction=TRACTION, frequency=FREQUENCY, phase=PHASE)],
        velocity=velocity,
    )
    path, waves = march(simulation, body)
    M, C, K = (
        body.on_free(part())
        for part in (body.assembly.mass, body.assembly.viscosity, body.assembly.stiffness)
    )
    alpha, beta, gamma = coefficients(scheme)
    instants = STEP * np.concatenate([[0.0], np.arange(1, STEPS + 1) + alpha])
    F = np.outer(np.cos(2 * np.pi * FREQUENCY * instants + PHASE), nodal_load(body)[body.free])
    work = viscous = numerical = 0.0
    between = [path[0], *((1 + alpha) * path[1:] - alpha * path[:-1])]  # U and V of a step
    for n in range(BEGIN, STEPS):
        (u, v, a), (du, _, da) = 0.5 * (path[n] + path[n + 1]), path[n + 1] - path[n]
        U, V, _ = 0.5 * (between[n] + between[n + 1])
        middle = 0.5 * (F[n] + F[n + 1]) - alpha * (F[n + 1] - F[n])  # the load in the middle of the step
        work += float(du @ middle)
        viscous += float(du @ (C @ V))
        numerical += -STEP * (gamma - 0.5) * float(v @ (M @ da)) - alpha * float(du @ (F[n + 1] - F[n]))
        numerical += STEP**2 * (beta - gamma / 2) * float(da @ (M @ a)) + float(du @ (K @ (U - u)))
    energies = [0.5 * float(v @ (M @ v) + u @ (K @ u)) for u, v, _ in path]
    largest = max(energies)
    yield zero(
        name="balance",
        quantity="change of energy less works and losses, over the largest energy",
        value=(energies[-1] - energies[BEGIN] - (work - viscous - numerical)) / largest,
        tolerance=1e3 * SOLVES,
        because="80 solves to 1e-13 each, with a margin of ten for their sum",
    )
    for what, wave, expected in (
        ("work of the load", "load_work", work),
        ("viscous loss", "viscous_loss", viscous),
        ("loss of the time scheme", "numerical_loss", numerical),
    ):
        yield Check(
            name=wave.replace("_", "-"),
            quantity=f"{what} after the first {BEGIN} steps, over the largest energy",
            value=float(waves[wave][-1] - waves[wave][BEGIN - 1]) / largest,
            reference=expected / largest,
            tolerance=1e3 * SOLVES,
            because="80 solves to 1e-13 each, with a margin of ten for their sum",
            of="unit",
        )


def march(simulation: engine.Simulation, body: Body) -> tuple[Array, dict[str, Array]]:
    """(STEPS + 1, 3, free): u, v and a; and the waveforms."""

    def state() -> Array:
        parts = (simulation.displacement, simulation.velocity, simulation.acceleration)
        return np.stack([np.ravel(part)[body.free] for part in parts])

    path, parts = [state()], []
    for _ in range(STEPS):
        parts.append(simulation.advance(1))
        path.append(state())
    return np.array(path), {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def free_motion() -> Iterator[Check]:
    """A block without supports under a constant load, and one under gravity."""
    body = block()
    load = engine.Load(surface="x_max", traction=TRACTION)
    pushed = body.simulation(scheme=SCHEMES["HHT(-0.3)"], step=STEP, solver_tolerance=SOLVES, loads=[load])
    pushed.advance(STEPS)
    t = STEP * STEPS
    mass = body.whole(body.assembly.mass())
    momentum = (mass @ np.ravel(pushed.velocity)).reshape(-1, 3).sum(axis=0)
    force = np.array(TRACTION) * SIZE[1] * SIZE[2]
    for k, axis in enumerate("xyz"):
        yield Check(
            name=f"momentum-{axis}",
            quantity=f"momentum along {axis} after {STEPS} steps under a constant force",
            unit="kg m/s",
            value=float(momentum[k]),
            reference=float(force[k] * t),
            tolerance=1e3 * SOLVES,
            because="80 solves to 1e-13 each, with a margin of ten for their sum",
        )
    falling = body.simulation(
        scheme=SCHEMES["trapezoidal"], step=STEP, solver_tolerance=SOLVES, gravity=(0.0, 0.0, -9.81)
    )
    falling.advance(STEPS)
    off = np.abs(np.asarray(falling.displacement) - [0, 0, -0.5 * 9.81 * t**2]).max()
    worst_node = falling.displacement[np.abs(falling.displacement[:, 2] + 0.5 * 9.81 * t**2).argmax(), 2]
    yield Check(
        name="fall",
        quantity="vertical way of the node that is furthest from free fall",
        unit="m",
        value=float(worst_node),
        reference=-0.5 * 9.81 * t**2,
        tolerance=1e4 * SOLVES,
        because="80 solves to 1e-13 each, summed twice",
    )
    yield zero(
        name="strain",
        quantity="largest deviation of any node from free fall, over the way",
        value=float(off / (0.5 * 9.81 * t**2)),
        tolerance=1e4 * SOLVES,
        because="80 solves to 1e-13 each, summed twice",
    )


CASES = (
    *(
        Case(
            f"energy-{name}",
            f"With {scheme} the energy of a driven viscous block is the load's work less what "
            "viscosity and scheme took, "
            "each term by its own formula.",
            "R13: dE = du . f - du . C V - D, D of beta, gamma and alpha",
            partial(ledger, name),
        )
        for name, scheme in LEDGERS.items()
    ),
    Case(
        "free-motion",
        "A body without supports gains the momentum of the force on it, and falls without a strain.",
        "R10; F t and g t^2 / 2",
        free_motion,
    ),
)

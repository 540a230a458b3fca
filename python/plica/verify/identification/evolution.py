"""The evolution of HHT as a matrix, against the engine and against the equations of a step."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

import plica
from plica.identify import hht_evolution, scene_evolution
from plica.runs.build import build_simulation
from plica.verify.case import Case, Check

__all__ = ["CASES"]

Array = NDArray[np.float64]

STEP, ALPHA, MASSES = 5e-5, -0.3, 5
UNITS = np.repeat([1e-6, 1e-2, 1e2], MASSES)  # m, m/s, m/s^2


def direct_step(matrices: tuple[Array, ...], z: Array, forces: Array, h: float, alpha: float) -> Array:
    """u1, v1, a1 by the nine equations of a step at once: Newmark's two and the balance of forces."""
    M, C, K = matrices
    m = len(M)
    beta, gamma, one = (1 - alpha) ** 2 / 4, 0.5 - alpha, 1 + alpha
    u, v, a = z.reshape(3, m)
    unit, zero = np.eye(m), np.zeros((m, m))
    left = np.block(
        [[unit, zero, -beta * h**2 * unit], [zero, unit, -gamma * h * unit], [one * K, one * C, M]]
    )
    right = np.concatenate(
        [
            u + h * v + h**2 * (0.5 - beta) * a,
            v + (1 - gamma) * h * a,
            one * forces[1] - alpha * forces[0] + alpha * (C @ v + K @ u),
        ]
    )
    row = np.repeat([1e-6, 1e-2, 1e-2], m)  # the rows in units of their own
    column = np.repeat([1e-6, 1e-2, 1e2], m)
    scaled: Array = np.linalg.solve(left * column / row[:, None], right / row) * column
    return scaled


def direct() -> Iterator[Check]:
    """A chain of masses of 0.1 g between springs."""
    K = 1e4 * (2 * np.eye(MASSES) - np.eye(MASSES, k=1) - np.eye(MASSES, k=-1))
    M = 1e-4 * (np.eye(MASSES) + 0.2 * (np.eye(MASSES, k=1) + np.eye(MASSES, k=-1)))
    C = 2e-6 * K
    made = hht_evolution(M, C, K, STEP, alpha=ALPHA)
    rng = np.random.default_rng(1)
    z, forces = UNITS * rng.standard_normal(3 * MASSES), 1e-2 * rng.standard_normal((2, MASSES))
    exact = direct_step((M, C, K), z, forces, STEP, ALPHA) / UNITS
    stepped = (made.G @ z + made.input(forces)[0]) / UNITS
    k = int(np.argmax(np.abs(stepped - exact)))
    yield Check(
        name="state",
        quantity="of displacements, velocities and accelerations after a step the one that is furthest off, "
        "in units of 1 um, 1 cm/s, 100 m/s^2",
        value=float(stepped[k]),
        reference=float(exact[k]),
        tolerance=1e-12 * float(np.abs(exact).max()),
        because="round-off of a system with a condition number below 1e4, over the largest",
        of="unit",
    )


def engine() -> Iterator[Check]:
    """A viscous bar of a scene, ten steps from its first."""
    scene = plica.Scene(
        plica.Block(size=("10 mm", "2 mm", "2 mm"), divisions=(4, 1, 1)),
        {"body": plica.Tissue(E="20 kPa", nu=0.3, viscosity=0.1)},
        time=plica.Stepping(step="0.1 ms", duration="4 ms"),
        supports=plica.Supports(fixed=["x_min"]),
        initial=plica.Initial(velocity={"body": (0.0, 0.0, "0.1 m/s")}),
        solver=plica.Solver(tolerance=1e-13),
    )
    made, matrices = scene_evolution(scene)
    simulation = build_simulation(scene)

    def state() -> Array:
        parts = (simulation.displacement, simulation.velocity, simulation.acceleration)
        return np.concatenate([np.asarray(part).reshape(-1)[matrices.free] for part in parts])

    simulation.advance(1)
    z = state()
    for _ in range(10):
        z = made.G @ z
    simulation.advance(10)
    exact = state()
    for name, found, expected in zip(
        ("displacement", "velocity", "acceleration"), z.reshape(3, -1), exact.reshape(3, -1), strict=True
    ):
        k = int(np.argmax(np.abs(found - expected)))
        largest = float(np.abs(expected).max())
        yield Check(
            name=name,
            quantity=f"{name} after ten steps, over the largest, where it is furthest off",
            value=float(found[k]) / largest,
            reference=float(expected[k]) / largest,
            tolerance=1e-9,
            because="ten solves of the engine to 1e-13, of which accelerations take 1 / (beta h^2 omega^2)",
            of="unit",
        )


CASES = (
    Case(
        "evolution",
        "The matrix that takes a state of HHT to the next is what its equations say.",
        "Newmark's equations and the balance of forces, solved together",
        direct,
    ),
    Case(
        "evolution-engine",
        "The matrix of a scene's evolution takes its state where the engine takes it.",
        "ten steps of the engine",
        engine,
    ),
)

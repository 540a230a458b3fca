"""Time schemes on free vibration in one mode of a block, whose motion is a cosine."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from math import cos, pi, sin, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine as engine
from plica.bench.body import SCHEMES, Body
from plica.bench.case import Case, Claim, Method
from plica.bench.families.assembly import (
    DENSITY,
    MU,
    NU,
    OMEGA,
    Matrices,
    block,
    plica_matrices,
    scikit_fem_matrices,
    scikit_fem_mesh,
)
from plica.bench.families.newmark import trapezoidal
from plica.bench.record import Level, Row

__all__ = ["CASES"]

Array = NDArray[np.float64]

PERIODS = 4.125  # where neither displacement nor velocity vanishes
SWING = 1e-4  # m
SOLVES = 1e-12


class Motion:
    """The mode on all unknowns, its frequency, and displacement and velocity that were found at the end."""

    def __init__(self, mode: Array, omega: float, u: Array, v: Array, free: NDArray[np.intp]) -> None:
        self.mode, self.omega, self.u, self.v, self.free = mode, omega, u, v, free


def _mode(made: Matrices) -> tuple[Array, float]:
    """The discrete mode next to the exact one, its largest entry 1, on all unknowns; and rad/s."""
    from scipy.sparse.linalg import eigsh

    free = made.free()
    stiffness, mass = (m.tocsc()[free][:, free].tocsc() for m in (made.stiffness, made.mass))
    exact = made.shape()[free]
    values, modes = eigsh(stiffness, k=4, M=mass, sigma=OMEGA**2, v0=exact)
    best = int(np.argmax(np.abs(modes.T @ (mass @ exact))))
    full = np.zeros(len(made.axes))
    full[free] = modes[:, best] / np.abs(modes[:, best]).max()
    return full, sqrt(float(values[best]))


@lru_cache(maxsize=2)
def _plica_mode(cells: int) -> tuple[Any, Array, float, NDArray[np.intp]]:
    mesh = block({"cells": cells, "elements": "quadratic"})
    made = plica_matrices(mesh)
    return mesh, *_mode(made), made.free()


def _end(level: Level, omega: float) -> tuple[float, int]:
    """Step (s) and number of steps."""
    per_period = int(level["steps a period"])
    return 2 * pi / omega / per_period, round(PERIODS * per_period)


def _engine(scheme: str, level: Level) -> Callable[[], Motion]:
    mesh, mode, omega, free = _plica_mode(int(level["cells"]))
    fixed = np.ones(len(mode), bool)
    fixed[free] = False
    material = engine.Material(engine.Isotropic(2 * MU * (1 + NU), NU), DENSITY, 0.0)
    body = Body(mesh, material, fixed.reshape(-1, 3))
    step, steps = _end(level, omega)

    def run() -> Motion:
        simulation = body.simulation(
            scheme=SCHEMES[scheme],
            step=step,
            solver_tolerance=SOLVES,
            displacement=SWING * mode.reshape(-1, 3),
        )
        simulation.advance(steps)
        u, v = (np.ravel(field) / SWING for field in (simulation.displacement, simulation.velocity))
        return Motion(mode, omega, u, v, free)

    return run


def _scikit_fem(level: Level) -> Callable[[], Motion]:
    """Its matrices, the trapezoidal rule and SuperLU of SciPy."""
    from scipy.sparse.linalg import factorized

    mesh = scikit_fem_mesh(level)
    mode, omega = _mode(scikit_fem_matrices(mesh, True))
    step, steps = _end(level, omega)

    def run() -> Motion:
        made = scikit_fem_matrices(mesh, True)
        free = made.free()
        mass, stiffness = (m.tocsc()[free][:, free].tocsc() for m in (made.mass, made.stiffness))
        u, v = np.zeros(len(mode)), np.zeros(len(mode))
        u[free], v[free] = trapezoidal(mass, stiffness, factorized, mode[free], step, steps)
        return Motion(mode, omega, u, v, free)

    return run


def _judge(level: Level, found: Motion, truth: None) -> dict[str, float]:
    """u = mode cos(omega t), v = -omega mode sin(omega t); nothing else may move."""
    step, steps = _end(level, found.omega)
    angle, size = found.omega * step * steps, float(np.linalg.norm(found.mode))
    return {
        "displacement": float(np.linalg.norm(found.u - cos(angle) * found.mode)) / size,
        "velocity": float(np.linalg.norm(found.v / found.omega + sin(angle) * found.mode)) / size,
    }


def _far_behind(rows: Sequence[Row]) -> bool | None:
    """Newmark(1, 3/2) beside the trapezoidal rule, at every step."""
    errors: dict[str, dict[object, float]] = {}
    for row in rows:
        errors.setdefault(row.method, {})[row.level["steps a period"]] = row.errors["displacement"] or 0.0
    if not {"trapezoidal", "Newmark(1, 3/2)"} <= errors.keys():
        return None
    return all(error > 10 * errors["trapezoidal"][n] for n, error in errors["Newmark(1, 3/2)"].items())


def _order(scheme: str, order: int) -> Callable[[Sequence[Row]], bool | None]:
    """Between the two shortest steps the displacement's error falls at this order, to a tenth of it."""

    def holds(rows: Sequence[Row]) -> bool | None:
        found = {
            int(row.level["steps a period"]): row.errors["displacement"]
            for row in rows
            if row.method == scheme
        }
        if len(found) < 2:
            return None
        coarse, fine = sorted(found)[-2:]
        first, last = found[coarse], found[fine]
        if first is None or last is None or last <= 0:
            return False
        return bool(abs(np.log(first / last) / np.log(fine / coarse) - order) < 0.1 * order)

    return holds


def _levels(cells: int, per_period: Sequence[int]) -> tuple[Level, ...]:
    return tuple({"cells": cells, "elements": "quadratic", "steps a period": n} for n in per_period)


CASES = (
    Case(
        name="vibration",
        does="A block swings in one mode for four periods and an eighth, made and run from its mesh.",
        reference="the cosine of the discrete mode",
        errors={
            "displacement": "at the end, over the amplitude",
            "velocity": "likewise, over its amplitude",
        },
        levels={
            "small": _levels(2, (80, 160)),
            "full": _levels(4, (20, 40, 80, 160, 320)),
        },
        methods=(
            *(Method(scheme, partial(_engine, scheme)) for scheme in SCHEMES),
            Method("scikit-fem, trapezoidal", _scikit_fem, "skfem", "scikit-fem"),
        ),
        truth=lambda level: None,
        judge=_judge,
        claims=(
            Claim("the trapezoidal rule is of order 2", _order("trapezoidal", 2)),
            Claim("HHT(-0.3) is of order 2", _order("HHT(-0.3)", 2)),
            Claim(
                "Newmark(1, 3/2) is ten times and more behind the trapezoidal rule",
                _far_behind,
            ),
        ),
    ),
)

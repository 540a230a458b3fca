"""Time schemes on free vibration in one mode of a block, whose motion is a cosine."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from math import cos, pi, sin
from typing import Any

import numpy as np
from scipy.sparse import diags_array

from benchmarks.dynamics.newmark import trapezoidal
from benchmarks.harness.case import Case, Claim, Method
from benchmarks.harness.case_record import Level, Row
from benchmarks.harness.claims import of_order
from benchmarks.tissue.peers import (
    MATERIAL,
    Array,
    Assembled,
    discrete_mode,
    mesh_of,
    ngsolve_assembly,
    plica_assembly,
    scikit_fem_assembly,
)
from plica import _engine as engine
from plica.verify.bodies.body import SCHEMES, Body

__all__ = ["CASES"]

PERIODS = 4.125  # where neither displacement nor velocity vanishes
SWING = 1e-4  # m
SOLVES = 1e-12
CENTRAL = "central differences"
LEAST_STEPS = 11
"""A period and cell, of central differences: what they are stable with, 10.9, rounded up."""


@dataclass(frozen=True)
class Motion:
    """On the free unknowns, over the swing."""

    mode: Array
    omega: float
    """rad/s."""
    u: Array
    v: Array
    """Found at the end; 1/s."""


@lru_cache(maxsize=2)
def _plica_mode(cells: int, lumped: bool) -> tuple[Array, float, Any]:
    """The discrete mode with a largest entry of 1, its frequency, and the numbers of its unknowns."""
    level: Level = {"cells": cells, "elements": "quadratic"}
    made = plica_assembly(level)()
    if lumped:
        mesh = mesh_of(level)
        assembly = engine.Assembly(mesh, [MATERIAL], ["tissue"], np.zeros(len(mesh.cells), np.int32))
        made = replace(made, mass=diags_array(np.repeat(assembly.lumped_mass(), 3)))
    mode, omega = discrete_mode(made)
    return mode / np.abs(mode).max(), omega, made.unknowns().free


def _span(level: Level, omega: float) -> tuple[float, int]:
    """Step (s) and number of steps."""
    per_period = int(level["steps a period"])
    return 2 * pi / omega / per_period, round(PERIODS * per_period)


def _engine(scheme: str, level: Level) -> Callable[[], Motion]:
    lumped = scheme == CENTRAL
    mode, omega, free = _plica_mode(int(level["cells"]), lumped)
    mesh = mesh_of(level)
    start, fixed = np.zeros(3 * len(mesh.points)), np.ones(3 * len(mesh.points), bool)
    start[free], fixed[free] = SWING * mode, False
    body = Body(mesh, MATERIAL, fixed.reshape(-1, 3))
    step, steps = _span(level, omega)

    def run() -> Motion:
        simulation = body.simulation(
            scheme=engine.CentralDifferences() if lumped else SCHEMES[scheme],
            step=step,
            lumped_mass=lumped,
            solver_tolerance=SOLVES,
            displacement=start.reshape(-1, 3),
        )
        simulation.advance(steps)
        u, v = (np.ravel(found)[free] / SWING for found in (simulation.displacement, simulation.velocity))
        return Motion(mode, omega, u, v)

    return run


def _peer(assembly: Callable[[Level], Callable[[], Assembled]], level: Level) -> Callable[[], Motion]:
    """A peer's matrices, and the trapezoidal rule with SuperLU of SciPy."""
    from scipy.sparse.linalg import splu

    make = assembly(level)
    mode, omega = discrete_mode(make())
    step, steps = _span(level, omega)

    def run() -> Motion:
        stiffness, mass = make().on_free()
        u, v = trapezoidal(mass, stiffness, lambda matrix: splu(matrix).solve, mode, step, steps)
        return Motion(mode, omega, u, v)

    return run


def _judge(level: Level, found: Motion, truth: None) -> dict[str, float]:
    """u = mode cos(omega t), v = -omega mode sin(omega t); nothing else may move."""
    step, steps = _span(level, found.omega)
    angle, size = found.omega * step * steps, float(np.linalg.norm(found.mode))
    return {
        "displacement": float(np.linalg.norm(found.u - cos(angle) * found.mode)) / size,
        "velocity": float(np.linalg.norm(found.v / found.omega + sin(angle) * found.mode)) / size,
    }


def _far_behind(rows: Sequence[Row]) -> bool | None:
    """Newmark(1, 3/2) beside the trapezoidal rule; with longer steps it has nothing left to lose."""
    errors: dict[str, dict[object, float]] = {}
    for row in (row for row in rows if int(row.level["steps a period"]) >= 80):
        errors.setdefault(row.method, {})[row.level["steps a period"]] = row.errors["displacement"] or 0.0
    if not {"trapezoidal", "Newmark(1, 3/2)"} <= errors.keys():
        return None
    return all(error > 10 * errors["trapezoidal"][n] for n, error in errors["Newmark(1, 3/2)"].items())


def _levels(cells: int, per_period: Sequence[int]) -> tuple[Level, ...]:
    return tuple({"cells": cells, "elements": "quadratic", "steps a period": n} for n in per_period)


CASES = (
    Case(
        name="vibration",
        does="A block swings in one mode for four periods and an eighth, made and run from its mesh; with "
        "central differences its mass is lumped.",
        reference="the cosine of the discrete mode, of either mass its own",
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
            Method(
                CENTRAL,
                partial(_engine, CENTRAL),
                fits=lambda level: int(level["steps a period"]) >= LEAST_STEPS * int(level["cells"]),
            ),
            Method("scikit-fem, trapezoidal", partial(_peer, scikit_fem_assembly), "skfem", "scikit-fem"),
            Method("NGSolve, trapezoidal", partial(_peer, ngsolve_assembly), "ngsolve"),
        ),
        truth=lambda level: None,
        judge=_judge,
        claims=(
            Claim(
                "the trapezoidal rule is of order 2",
                of_order("trapezoidal", "displacement", "steps a period", 1.8, 2.2),
            ),
            Claim(
                "HHT(-0.3) is of order 2", of_order("HHT(-0.3)", "displacement", "steps a period", 1.8, 2.2)
            ),
            Claim(
                "central differences are of order 2",
                of_order(CENTRAL, "displacement", "steps a period", 1.8, 2.2),
            ),
            Claim(
                "from 80 steps a period on Newmark(1, 3/2) is ten times behind the trapezoidal rule",
                _far_behind,
            ),
        ),
        threads=(1,),
    ),
)

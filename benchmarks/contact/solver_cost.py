"""The three ways to solve the equations of contact by multipliers, by tolerance."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.case import Case, Claim, Method
from benchmarks.harness.case_record import Level
from benchmarks.harness.claims import at_most
from plica import _engine as engine
from plica.verify.bodies.body import Body, facing

__all__ = ["CONTACT_SOLVER"]

Array = NDArray[np.float64]

E, NU, DENSITY, SIDE = 20e3, 0.45, 1040.0, 0.01  # Pa, -, kg/m^3, m
EXACT = 1e-13
GAP, SPEED = 0.02, 0.5  # of an edge; m/s


def _collision(solver: str, tolerance: float, cells: int) -> Callable[[], Array]:
    """Two cubes that meet flat, without supports; the force between them at the end of each step."""
    size = (SIDE,) * 3
    shape: dict[str, Any] = {"size": size, "divisions": (cells,) * 3}
    left = engine.block_mesh(corner=(-SIDE, 0, 0), **shape)
    right = engine.block_mesh(corner=(GAP * SIDE / cells, 0, 0), **shape)
    mesh, on_right, airway = facing(left, right)
    body = Body(
        mesh, engine.Material(engine.Isotropic(E, NU), DENSITY, 0.0), np.zeros((len(mesh.points), 3), bool)
    )
    velocity = np.zeros((len(mesh.points), 3))
    velocity[:, 0] = np.where(on_right, -SPEED, SPEED)
    step = 0.5 * SIDE / cells / float(np.sqrt(E / DENSITY))

    def run() -> Array:
        simulation = body.simulation(
            scheme=engine.HilberHughesTaylor(alpha=-0.3),
            step=step,
            solver_tolerance=tolerance,
            contact=engine.Contact(airway=airway, enforcement=engine.Multipliers(solver=solver)),
            velocity=velocity,
        )
        forces = []
        for _ in range(4 * cells):
            simulation.advance(1)
            forces.append(np.ravel(simulation.contact_force).copy())
        found = np.concatenate(forces)
        if not found.any():
            raise RuntimeError("the cubes never touch: nothing is measured.")
        return found

    return run


def _contact(solver: str, level: Level) -> Callable[[], Array]:
    return _collision(solver, float(level["tolerance"]), int(level["cells"]))


def _reached(solver: str, level: Level) -> bool:
    """GMRES does not come to an end with tighter solves than 1e-6 on the full size."""
    return solver != "gmres" or float(level["tolerance"]) >= 1e-6 or int(level["cells"]) <= 3


@lru_cache(maxsize=1)
def _exact_forces(cells: int) -> Array:
    return _collision("saddle", EXACT, cells)()


def _force_error(level: Level, found: Array, truth: Array) -> dict[str, float]:
    return {"force": float(np.linalg.norm(found - truth) / np.linalg.norm(truth))}


CONTACT_SOLVER = Case(
    name="contact-solver",
    does="Two free cubes meet flat; contact by multipliers, its equations solved in three ways.",
    reference=f"forces by the saddle point with solves to {EXACT:g}",
    errors={"force": "of all contact forces of all steps, relative"},
    levels={
        "small": ({"cells": 3, "tolerance": 1e-8},),
        "full": tuple({"cells": 8, "tolerance": tolerance} for tolerance in (1e-4, 1e-6, 1e-8, 1e-10)),
    },
    methods=tuple(
        Method(label, partial(_contact, name), fits=partial(_reached, name))
        for label, name in (
            ("condensed", "condensed"),
            ("saddle point", "saddle"),
            ("GMRES, Eq. (29)", "gmres"),
        )
    ),
    truth=lambda level: _exact_forces(int(level["cells"])),
    judge=_force_error,
    claims=(
        Claim(
            "the forces of the condensed solver are right to 1e-6 at every tolerance",
            at_most("condensed", 1e-6, "force"),
        ),
    ),
    threads=(1,),
)

"""Linear and saddle-point solvers by tolerance: what a tighter solve costs, and what it gives the motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine as engine
from plica.bench.body import Body, free_block
from plica.bench.case import Case, Claim, Method
from plica.bench.families.newmark import trapezoidal
from plica.bench.record import Level, Row

__all__ = ["CASES"]

Array = NDArray[np.float64]

E, NU, DENSITY, SIDE = 20e3, 0.45, 1040.0, 0.01  # Pa, -, kg/m^3, m
SWING, STEPS = 1e-4, 30  # m
EXACT = 1e-13
GAP, SPEED = 0.02, 0.5  # of the side; m/s


def _block(cells: int) -> Body:
    """Of quadratic tetrahedra, held at one side."""
    law = engine.Isotropic(E, NU)
    return free_block(law, (SIDE,) * 3, (cells,) * 3, 2, density=DENSITY).hold("x_min")


def _swing(body: Body) -> Array:
    """(n, 3) m, the start: bent and stretched, smooth."""
    x = np.asarray(body.mesh.points) / SIDE
    bent = np.sin(0.5 * pi * x[:, 0])
    return SWING * np.stack([0.5 * bent * x[:, 1], bent, bent * x[:, 2]], axis=1) * ~body.fixed


def _engine_run(solver: Any, level: Level) -> Callable[[], Array]:
    body = _block(int(level["cells"]))
    start = _swing(body)

    def run() -> Array:
        simulation = body.simulation(
            scheme=engine.Newmark(),
            step=1e-6 * float(level["step (us)"]),
            solver_tolerance=float(level["tolerance"]),
            solver=solver,
            displacement=start,
        )
        simulation.advance(STEPS)
        return np.ravel(simulation.displacement)

    return run


def _matrices(level: Level) -> tuple[Body, Any, Any]:
    body = _block(int(level["cells"]))
    return body, body.on_free(body.assembly.mass()), body.on_free(body.assembly.stiffness())


def _scipy(
    solver: Callable[[float], Callable[[Any], Callable[[Array], Array]]], level: Level
) -> Callable[[], Array]:
    body, mass, stiffness = _matrices(level)
    start = np.ravel(_swing(body))[body.free]

    def run() -> Array:
        made = solver(float(level["tolerance"]))
        u, _ = trapezoidal(mass, stiffness, made, start, 1e-6 * float(level["step (us)"]), STEPS)
        return np.ravel(body.field(u))

    return run


def _super_lu(tolerance: float) -> Callable[[Any], Callable[[Array], Array]]:
    from scipy.sparse.linalg import splu

    return lambda matrix: splu(matrix).solve


def _jacobi_cg(tolerance: float) -> Callable[[Any], Callable[[Array], Array]]:
    """Preconditioned by the diagonal, each solve from zero."""
    from scipy.sparse import dia_array
    from scipy.sparse.linalg import cg

    def made(matrix: Any) -> Callable[[Array], Array]:
        rows, n = matrix.tocsr(), matrix.shape[0]
        inverse = dia_array((1 / matrix.diagonal()[None], [0]), shape=(n, n))

        def solve(right: Array) -> Array:
            found, failed = cg(rows, right, rtol=tolerance, atol=0.0, M=inverse, maxiter=10 * n)
            if failed:
                raise RuntimeError(f"conjugate gradients end above {tolerance:g} after {failed} iterations.")
            return np.asarray(found)

        return solve

    return made


@lru_cache(maxsize=2)
def _refined_motion(cells: int, step: float) -> Array:
    """By SuperLU, each solve refined once."""
    from scipy.sparse.linalg import factorized

    body, mass, stiffness = _matrices({"cells": cells})

    def refined(matrix: Any) -> Callable[[Array], Array]:
        solve = factorized(matrix)

        def twice(right: Array) -> Array:
            first = solve(right)
            return np.asarray(first + solve(right - matrix @ first))

        return twice

    u, _ = trapezoidal(mass, stiffness, refined, np.ravel(_swing(body))[body.free], step, STEPS)
    return np.ravel(body.field(u))


def _motion_error(level: Level, found: Array, truth: Array) -> dict[str, float]:
    return {"motion": float(np.linalg.norm(found - truth) / np.linalg.norm(truth))}


def _collision(solver: str, tolerance: float, cells: int) -> Callable[[], Array]:
    """Two cubes that meet flat, without supports; the force between them at the end of each step."""
    size = (SIDE,) * 3
    shape: dict[str, Any] = {"size": size, "divisions": (cells,) * 3}
    left = engine.block_mesh(corner=(-SIDE, 0, 0), **shape)
    right = engine.block_mesh(corner=(GAP * SIDE / cells, 0, 0), **shape)
    mesh = engine.combine(left, right, "a.", "b.")
    airway = engine.matched_airway(mesh.points, mesh.surfaces["a.x_max"], mesh.surfaces["b.x_min"], (1, 0, 0))
    body = Body(
        mesh, engine.Material(engine.Isotropic(E, NU), DENSITY, 0.0), np.zeros((len(mesh.points), 3), bool)
    )
    velocity = np.zeros((len(mesh.points), 3))
    velocity[:, 0] = np.where(np.arange(len(mesh.points)) < len(left.points), SPEED, -SPEED)
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


@lru_cache(maxsize=1)
def _exact_forces(cells: int) -> Array:
    return _collision("saddle", EXACT, cells)()


def _force_error(level: Level, found: Array, truth: Array) -> dict[str, float]:
    return {"force": float(np.linalg.norm(found - truth) / np.linalg.norm(truth))}


def _follows_tolerance(
    error: str, methods: Sequence[str], factor: float
) -> Callable[[Sequence[Row]], bool | None]:
    """Whether the error of these is nowhere above so many times the tolerance."""

    def holds(rows: Sequence[Row]) -> bool | None:
        found = [
            (row.errors.get(error), float(row.level["tolerance"])) for row in rows if row.method in methods
        ]
        return None if not found else all(e is not None and e <= factor * t for e, t in found)

    return holds


TIGHT, LOOSE = 1e-10, 1e-4


def _linear_levels(cells: int, steps: Sequence[int], tolerances: Sequence[float]) -> tuple[Level, ...]:
    return tuple(
        {"cells": cells, "step (us)": step, "tolerance": tolerance}
        for step in steps
        for tolerance in tolerances
    )


CASES = (
    Case(
        name="linear-solver",
        does=f"{STEPS} steps of a block of quadratic tetrahedra that swings freely, trapezoidal rule.",
        reference="the same steps solved by SuperLU with refinement (SciPy)",
        errors={"motion": "of the displacement at the end, relative"},
        levels={
            "small": _linear_levels(2, (50,), (1e-4, 1e-8)),
            "full": _linear_levels(6, (50, 1000), (1e-4, 1e-6, 1e-8, 1e-10)),
        },
        methods=(
            Method("Cholesky", partial(_engine_run, engine.Cholesky())),
            Method("conjugate gradients", partial(_engine_run, engine.ConjugateGradients())),
            Method("SciPy, conjugate gradients", partial(_scipy, _jacobi_cg), "scipy"),
            Method(
                "SciPy, SuperLU",
                partial(_scipy, _super_lu),
                "scipy",
                fits=lambda level: level["tolerance"] == LOOSE,
            ),
        ),
        truth=lambda level: _refined_motion(int(level["cells"]), 1e-6 * float(level["step (us)"])),
        judge=_motion_error,
        problem=("step (us)",),
        claims=(
            Claim(
                "the motion's error is below a hundred tolerances, Cholesky or conjugate gradients",
                _follows_tolerance("motion", ("Cholesky", "conjugate gradients"), 100),
            ),
        ),
    ),
    Case(
        name="contact-solver",
        does="Two free cubes meet flat; contact by multipliers, its equations solved in three ways.",
        reference=f"forces by the saddle point with solves to {EXACT:g}",
        errors={"force": "of all contact forces of all steps, relative"},
        levels={
            "small": ({"cells": 3, "tolerance": 1e-8},),
            "full": tuple({"cells": 8, "tolerance": tolerance} for tolerance in (1e-4, 1e-6, 1e-8, 1e-10)),
        },
        methods=tuple(
            Method(said, partial(_contact, name))
            for said, name in (
                ("condensed", "condensed"),
                ("saddle point", "saddle"),
                ("GMRES, Eq. (29)", "gmres"),
            )
        ),
        truth=lambda level: _exact_forces(int(level["cells"])),
        judge=_force_error,
        claims=(
            Claim(
                "the forces' error of the condensed solver is below a thousand tolerances",
                _follows_tolerance("force", ("condensed",), 1000),
            ),
        ),
    ),
)

"""Linear solvers by tolerance: what a tighter solve costs, and what it gives the motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contact.solver_cost import CONTACT_SOLVER
from benchmarks.dynamics.newmark import trapezoidal
from benchmarks.harness.case import Case, Claim, Method
from benchmarks.harness.case_record import Level
from benchmarks.harness.claims import within_tolerance
from plica import _engine as engine
from plica.verify.bodies.body import Body, free_block

__all__ = ["CASES"]

Array = NDArray[np.float64]

E, NU, DENSITY, SIDE = 20e3, 0.45, 1040.0, 0.01  # Pa, -, kg/m^3, m
SWING, STEPS = 1e-4, 30  # m


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


LOOSE = 1e-4


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
                "with a Cholesky factor the motion's error is below a hundred tolerances",
                within_tolerance("motion", "Cholesky", 100),
            ),
            Claim(
                "with conjugate gradients it is at steps of 50 us",
                within_tolerance(
                    "motion", "conjugate gradients", 100, lambda level: level["step (us)"] == 50
                ),
            ),
        ),
    ),
    CONTACT_SOLVER,
)

"""Expected computing time of a level: from the run's step, for another mesh from a trial."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from plica import _engine
from plica.runs.basis_file import kept_basis
from plica.runs.build import build_simulation
from plica.runs.results import Run
from plica.runs.scene_mesh import scene_mesh
from plica.uncertainty.level import Basis, PlannedLevel, fields_of
from plica.uncertainty.start import Start, step_cost
from plica.units import clock

__all__ = ["Cost", "Own", "cost_of"]

_COST_EXPONENT = 1.3  # of the number of cells, for a first estimate
_HOPELESS = 8.0  # times the budget by that estimate, beyond which no trial is made


@dataclass(frozen=True)
class Own:
    """Data of the run from which costs of levels are estimated.

    Attributes
    ----------
    step : float
        Time of one step (s).
    mesh : TetMesh
    basis : (3 n, any) or None
        Basis of a reduced scene.
    """

    step: float
    mesh: _engine.TetMesh
    basis: Basis | None

    @staticmethod
    def of(run: Run) -> Own:
        """Of a run; raises InvalidInput if a reduced run has lost its basis."""
        scene, step = run.scene, run.seconds / max(run.steps, 1)
        mesh = scene_mesh(scene)
        if scene.reduction is None:
            return Own(step, mesh, None)
        return Own(step, mesh, kept_basis(run.directory, scene, mesh, resumed=True))


@dataclass(frozen=True)
class Cost:
    """Expected time of a level (s), and a description."""

    seconds: float
    note: str


def cost_of(level: PlannedLevel, run: Run, start: Start | None, mine: Own, left: float) -> Cost:
    """From the run's measured step; for another mesh, from a measured ratio, unless a first estimate is far
    beyond the seconds that are left."""
    steps = level.scene.time.steps
    if level.kind == "step":
        return Cost(steps * mine.step, _description(steps, mine.step))
    cells = len(level.mesh.cells) / len(run.mesh.cells)
    growth = cells**_COST_EXPONENT
    guess = growth * steps * mine.step
    if guess > _HOPELESS * max(left, 1.0):
        return Cost(guess, f"{cells:.3g} times the cells would take about {clock(guess)}")
    base = build_simulation(run.scene, mine.mesh, *_initial_fields(start))
    other = build_simulation(level.scene, level.mesh, *fields_of(level, run, start))
    step = mine.step * step_cost(other) / step_cost(base)
    return Cost(steps * step, _description(steps, step))


def _description(steps: int, step: float) -> str:
    return f"{steps} steps of {1e3 * step:.3g} ms are {clock(steps * step)}"


def _initial_fields(start: Start | None) -> tuple[Any, Any]:
    return (None, None) if start is None else (start.displacement, start.velocity)

"""A refinement level of a run: scene, mesh, initial state and expected time."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.runs.build import fixed_components
from plica.runs.results import Run
from plica.runs.scene_mesh import scene_mesh
from plica.scene.scene import Scene
from plica.uncertainty.meshes import OtherMesh
from plica.uncertainty.start import Start
from plica.units import clock

__all__ = ["Basis", "PlannedLevel", "fields_of", "lengthened"]

Basis = NDArray[np.float64]


@dataclass(frozen=True)
class PlannedLevel:
    """A level to be computed.

    Attributes
    ----------
    name : str
        Name of its directory.
    kind : "step" or "mesh"
    factor : float
        Refinement factor of its step or edges.
    scene : Scene
    other : OtherMesh or None
        None: the run's own mesh.
    seconds : float
        Expected time.
    basis : (3 n, any) or None
        Basis of a reduced scene: that of the run, so that only the step differs.
    """

    name: str
    kind: Literal["step", "mesh"]
    factor: float
    scene: Scene
    other: OtherMesh | None = None
    seconds: float = 0.0
    basis: Basis | None = field(default=None, repr=False, compare=False)

    @cached_property
    def mesh(self) -> _engine.TetMesh:
        """The mesh, built on first use."""
        return scene_mesh(self.scene) if self.other is None else self.other.build()

    @property
    def title(self) -> str:
        """A short title."""
        return f"step / {self.factor:g}" if self.kind == "step" else f"mesh x {self.factor:.3g}"

    def text(self) -> str:
        """One line for the plan."""
        step, count = self.scene.time.step, self.scene.time.steps
        return (
            f"{self.title:<12} {count:>7} steps of {1e6 * step:g} us  x {1e3 * self.seconds / count:8.3g} ms "
            f"= about {clock(self.seconds)}"
        )


def lengthened(level: PlannedLevel, steps: int) -> PlannedLevel:
    """The level with another number of steps."""
    return replace(level, scene=level.scene.replace({"time.duration": steps * level.scene.time.step}))


def fields_of(level: PlannedLevel, run: Run, start: Start | None) -> tuple[Any, Any]:
    """Initial displacement and velocity of a level; None, None if it starts like the scene."""
    if start is None:
        return None, None
    fixed = fixed_components(level.scene, level.mesh)
    return start.on(run.mesh, np.asarray(level.mesh.points), fixed, run.scene.symmetry)

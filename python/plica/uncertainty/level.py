"""A level of a run: its scene, its mesh, where it begins and what it is expected to take."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.phonation.run.build import fixed_components
from plica.phonation.run.results import Run
from plica.phonation.scene.mesh_source import build_mesh
from plica.phonation.scene.scene import Scene
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
        Of its directory.
    kind : "step" or "mesh"
    factor : float
        How many times as short its step, or its edges, are meant to be.
    scene : Scene
    other : OtherMesh or None
        None: the run's own mesh.
    seconds : float
        What it is expected to take.
    basis : (3 n, any) or None
        Of a reduced scene. By step the run's own, so that the step is all that differs. None: it is made when
        the level is run.
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
        """Built when it is asked for."""
        return build_mesh(self.scene.mesh, self.scene.source) if self.other is None else self.other.build()

    @property
    def title(self) -> str:
        """What it is, in two words."""
        return f"step / {self.factor:g}" if self.kind == "step" else f"mesh x {self.factor:.3g}"

    def text(self) -> str:
        """One line for the plan."""
        step, count = self.scene.time.step, self.scene.time.steps
        return (
            f"{self.title:<12} {count:>7} steps of {1e6 * step:g} us  x {1e3 * self.seconds / count:8.3g} ms "
            f"= about {clock(self.seconds)}"
        )


def lengthened(level: PlannedLevel, steps: int) -> PlannedLevel:
    """The level for so many steps."""
    return replace(level, scene=level.scene.replace({"time.duration": steps * level.scene.time.step}))


def fields_of(level: PlannedLevel, run: Run, start: Start | None) -> tuple[Any, Any]:
    """Displacement and velocity in which a level begins; None, None where it begins as the scene does."""
    if start is None:
        return None, None
    fixed = fixed_components(level.scene, level.mesh)
    return start.on(run.mesh, np.asarray(level.mesh.points), fixed, run.scene.symmetry)

"""Initial state of the levels of a steady vibration: the widest opening after the newest checkpoint of the
run.

Without contact, displacement and velocity can be transferred to another mesh. The steady states of the
levels are near that of the run, and the transient decays within a few cycles.
"""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.runs import checkpoint
from plica.runs.basis_file import kept_basis
from plica.runs.build import build_simulation
from plica.runs.continuation import holds_run
from plica.runs.results import Run
from plica.runs.scene_mesh import scene_mesh
from plica.scene.scene import Scene
from plica.scene.symmetry import mirrored_mean, symmetry_planes
from plica.storage.files import replaced, storage_errors
from plica.storage.hdf5 import create, put, put_text
from plica.storage.stored import Stored
from plica.uncertainty.transfer import transferred

__all__ = ["Start", "kept_start", "step_cost", "widest_opening"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Start:
    """A state of the tissue on the run's mesh.

    Attributes
    ----------
    time : float
        Time of the run (s).
    displacement, velocity : (n, 3) m and m/s
    """

    time: float
    displacement: Floats
    velocity: Floats

    def on(
        self, mesh: Any, points: Floats, fixed: NDArray[np.bool_], symmetry: str | None = None
    ) -> tuple[Floats, Floats]:
        """Displacement and velocity at another mesh's points, zero where fixed, with the scene's symmetry;
        `mesh` is that of the run."""
        if points.shape == np.shape(mesh.points) and np.array_equal(points, mesh.points):
            return self.displacement, self.velocity
        planes = symmetry_planes(symmetry)
        displacement, velocity = (
            np.where(fixed, 0.0, mirrored_mean(field, points, planes))
            for field in transferred(mesh, (self.displacement, self.velocity), points)
        )
        return displacement, velocity


def widest_opening(run: Run, limit: float | None = None) -> Start | None:
    """The state at the next maximum of the glottal area without contact after the newest checkpoint.

    None if there is no checkpoint that this version can continue, or no such opening within `limit` s of it
    (default: two cycles of 50 Hz).
    """
    held = checkpoint.newest(run.directory)
    if held is None:
        return None
    scene: Scene = run.scene
    mesh = scene_mesh(scene)
    basis = None if scene.reduction is None else kept_basis(run.directory, scene, mesh, resumed=True)
    simulation = build_simulation(scene, mesh, basis=basis)
    if held.state.keys() != simulation.state().keys():
        return None
    simulation.restore(dict(held.state))
    area, rising = np.inf, False
    for _ in range(round((0.04 if limit is None else limit) / scene.time.step)):
        before = Start(simulation.time, np.array(simulation.displacement), np.array(simulation.velocity))
        wave = simulation.advance(1)
        touching = "contact_rows" in wave and wave["contact_rows"][-1] > 0
        now = float(wave["minimum_area"][-1])
        if rising and not touching and 0 < now < area:
            return before
        rising, area = now > area, now
    return None


def kept_start(run: Run, path: Path) -> Start | None:
    """The widest opening, from the file of an earlier call if there is one.

    A file of another scene, length or version of plica is removed with its plan and levels; raises
    InvalidInput if the file is damaged.
    """
    identity = _identity(run)
    if path.is_file():
        held = _read(path, identity)
        if held is not None:
            return held
    _forget(path)
    found = widest_opening(run)
    if found is not None:
        replaced(path, lambda draft: _write(found, identity, draft))
    return found


def _read(path: Path, identity: Mapping[str, str | int]) -> Start | None:
    """The state in a file, or None if it is of another run."""
    with Stored(path, hint=f"Remove the directory {path.parent} to compute all levels again") as file:
        if json.loads(file.text("run")) != identity:
            return None
        return Start(float(file.read("time")), file.read("displacement"), file.read("velocity"))


def _identity(run: Run) -> dict[str, str | int]:
    """Identity of the run of a state and of the levels that start from it."""
    return {"scene": run.scene.digest(), "steps": run.steps, "plica": run.versions["plica"]}


def _forget(path: Path) -> None:
    """Remove a state with its plan and levels; the state last, so that an interrupted removal is repeated."""
    with storage_errors(path.parent):
        for level in path.parent.glob("orbit-*"):
            if holds_run(level):
                shutil.rmtree(level)
        path.with_name("plan.json").unlink(missing_ok=True)
        path.unlink(missing_ok=True)


def _write(start: Start, identity: Mapping[str, str | int], path: Path) -> None:
    with create(path) as file:
        put_text(file, "run", json.dumps(identity))
        put(file, "time", start.time, "s")
        put(file, "displacement", start.displacement, "m")
        put(file, "velocity", start.velocity, "m/s")


def step_cost(simulation: _engine.Simulation, steps: int = 6) -> float:
    """Measured time per step (s): the smaller of two measurements after the first steps."""
    simulation.advance(2)
    found = []
    for _ in range(2):
        begin = time.perf_counter()
        simulation.advance(steps)
        found.append((time.perf_counter() - begin) / steps)
    return min(found)

"""The full run from which a reduced scene computes its vectors."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput
from plica.runs.results import Run

__all__ = ["motion_digest", "stored_motion"]


def stored_motion(run: Run, mesh: _engine.TetMesh) -> NDArray[np.float32]:
    """The stored displacements (frames, n, 3) m of a run on this mesh.

    Raises InvalidInput for a run that is itself reduced, not finished, without frames or on another mesh.
    """
    key = f"reduction.full_run = {run.directory}"
    if run.scene.reduction is not None:
        raise InvalidInput(f"{key} is itself reduced; must be a run without reduction.")
    if run.status != "finished":
        raise InvalidInput(
            f"{key} is {run.status} after {run.steps} of {run.steps_asked} steps; must be finished. Continue "
            f"it with: plica run {run.directory / 'scene.toml'} -o {run.directory} --resume"
        )
    if not (np.array_equal(run.mesh.points, mesh.points) and np.array_equal(run.mesh.cells, mesh.cells)):
        raise InvalidInput(
            f"{key} is on another mesh, of {len(run.mesh.points)} nodes; must be on the scene's."
        )
    if not len(run.fields.get("displacement", ())):
        raise InvalidInput(
            f"{key} has no stored displacements; must have some steady cycles. Set its output.every."
        )
    return np.asarray(run.displacement)


def motion_digest(directory: Path) -> str:
    """Digest of a run's scene and of all its stored displacements; empty if there is no run.

    Of the checksums that the displacements are stored with: those that are read are verified by them.
    """
    try:
        run = Run.load(directory)
        found = hashlib.sha256(run.scene.digest().encode())
        found.update(np.ascontiguousarray(run.fields["time"]).tobytes())
        found.update(run.displacement.checksums.tobytes())
    except InvalidInput:
        return ""
    return found.hexdigest()

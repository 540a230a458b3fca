"""The full run of whose motion a basis is made."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput
from plica.runs.results import Run

__all__ = ["stored_motion"]


def stored_motion(run: Run, mesh: _engine.TetMesh) -> NDArray[np.float32]:
    """The stored displacements (frames, n, 3) m of a run on this mesh.

    Raises InvalidInput for a run that is itself reduced, not finished, without frames or on another mesh.
    """
    key = run.directory
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

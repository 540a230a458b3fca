"""The mesh of a scene at its posture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput, SceneError, nearest, one_of
from plica.runs.materials import materials_of
from plica.scene.held import fixed_components
from plica.scene.mesh.build import build_mesh
from plica.scene.posture import Posture
from plica.scene.scene import Scene

__all__ = ["at_posture", "scene_mesh"]

Floats = NDArray[np.float64]


def scene_mesh(scene: Scene) -> _engine.TetMesh:
    """The mesh of a scene, at its posture if it has one: what airflow, contact and motion see.

    Returns
    -------
    TetMesh
        `points` (n, 3) m and, with a posture, `rest` (n, 3) m, those of the scene's mesh.

    Raises
    ------
    SceneError
        As `build_mesh`, and if the tissue has no equilibrium at this posture.
    """
    return at_posture(scene, build_mesh(scene.mesh, scene.source))


def at_posture(scene: Scene, mesh: _engine.TetMesh) -> _engine.TetMesh:
    """A mesh of the scene at rest, brought to its posture."""
    posture = scene.posture
    if posture is None:
        return mesh
    for layer in posture.active_stress:
        if layer not in mesh.layer_names:
            raise SceneError(
                f"{scene.source}: posture.active_stress.{layer} is not a layer of the mesh; must be "
                f"{one_of(mesh.layer_names)}.{nearest(layer, mesh.layer_names)}"
            )
    if posture.stretch == 0 and not any(posture.active_stress.values()):
        return mesh
    fixed = fixed_components(scene, mesh)
    try:
        return _engine.stretched(
            mesh, *materials_of(scene, mesh), fixed=fixed, held=_held(posture, np.asarray(mesh.points), fixed)
        ).mesh
    except (InvalidInput, _engine.SolveFailed) as error:
        if isinstance(error, SceneError):
            raise
        raise SceneError(f"{scene.source}: {str(error).replace('Posture:', 'posture:')}") from None


def _held(posture: Posture, points: Floats, fixed: NDArray[np.bool_]) -> Floats:
    """(n, 3) m: where what is held goes."""
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    stretch = 1 + posture.stretch
    aside = stretch**-posture.contraction
    return np.where(fixed, (points - middle) * (np.array((aside, stretch, aside)) - 1), 0.0)

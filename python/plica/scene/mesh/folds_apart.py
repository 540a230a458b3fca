"""Whether the folds of a mirrored mesh are joined where the air must pass, or hang together by free nodes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plica.errors import SceneError
from plica.measures.contour import coronal_contours
from plica.scene.held import MeshArrays
from plica.scene.mesh.surface_fault import airway_fault
from plica.tetrahedron import EDGES

__all__ = ["require_apart"]

_FACES = ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))
_MANY = 0.25  # of the walls' area, seen along x
_ADVICE = "Leave a gap between the mesh of the fold and the plane x = 0, however small."


def require_apart(mesh: MeshArrays, fixed: NDArray[np.bool_], airway: str | None, where: str) -> None:
    """Raise SceneError unless the folds of a mirrored mesh are apart but for tissue that joins them by faces.

    Parameters
    ----------
    mesh : MeshArrays
        Mirrored in x = 0, where nodes have x = 0 exactly.
    fixed : (n, 3)
        Components held by supports.
    airway : str, optional
        The surface of the airflow: no tissue may cross the mid-coronal plane between its walls.
    where : str
        Prefix of the message.
    """
    if airway is not None and airway in mesh.surfaces:
        if _looks_both_ways(mesh, airway):
            raise SceneError(
                f'{where}: mesh.mirror: the walls of the airway "{airway}" that the file has look toward '
                "smaller and toward larger x; must all look toward the plane x = 0, as those of one fold. If "
                "the file has both folds, leave mirror out."
            )
        if fault := airway_fault(mesh, airway):
            raise SceneError(f'{where}: airflow.surface = "{airway}": {fault}')
        if (place := _across(mesh, airway)) is not None:
            raise SceneError(
                f"{where}: mesh.mirror: both folds are one tissue at {_text(place)} m, in the middle of the "
                f'airway "{airway}", as the mesh of the file reaches the plane x = 0 there; must not, as air '
                f"passes between the folds. {_ADVICE}"
            )
    points = np.asarray(mesh.points)
    hinges = _hinges(mesh)
    free = hinges[~fixed[hinges, 0]]
    if len(free):
        raise SceneError(
            f"{where}: mesh.mirror: node {free[0]} at {_text(points[free[0]])} m is of both folds, which no "
            f"face in the plane x = 0 joins there ({len(free)} such nodes are free); must be held along x in "
            f"supports, as where the folds meet in a commissure. {_ADVICE}"
        )


def _looks_both_ways(mesh: MeshArrays, airway: str) -> bool:
    """Whether walls of the right fold look away from x = 0 by a quarter or more of what looks toward it."""
    points, faces = np.asarray(mesh.points), np.asarray(mesh.surfaces[airway])[:, :3]
    a, b, c = (points[faces[:, k]] for k in range(3))
    lateral = np.cross(b - a, c - a)[(a + b + c)[:, 0] > 0, 0]
    toward, away = -lateral[lateral < 0].sum(), lateral[lateral > 0].sum()
    return bool(min(toward, away) > _MANY * max(toward, away))


def _across(mesh: MeshArrays, airway: str) -> NDArray[np.float64] | None:
    """A point of the tissue in x = 0 and the airway's mid-coronal plane between the airway's lower and upper
    end, or at these; None if there is none."""
    points, faces = np.asarray(mesh.points), np.asarray(mesh.surfaces[airway])[:, :3]
    lines = [line for line in coronal_contours(points, faces) if len(line)]
    if not lines:
        return None
    low, high = (find([end(line[:, 0]) for line in lines]) for find, end in ((max, np.min), (min, np.max)))
    y = points[np.unique(faces), 1]
    middle = 0.5 * (y.min() + y.max())
    cells = np.asarray(mesh.cells)
    edges = np.concatenate([cells[:, list(ends)] for ends in EDGES])
    edges = np.unique(edges[(points[edges, 0] == 0).all(axis=1)], axis=0)
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    crossing = np.minimum(a[:, 1], b[:, 1]) <= middle
    crossing &= np.maximum(a[:, 1], b[:, 1]) >= middle
    a, b = a[crossing], b[crossing]
    length = b[:, 1] - a[:, 1]
    share = np.divide(middle - a[:, 1], length, out=np.full(len(a), 0.5), where=length != 0)
    at = a + share[:, None] * (b - a)
    between = (at[:, 2] >= low) & (at[:, 2] <= high)
    return at[between][0] if between.any() else None


def _hinges(mesh: MeshArrays) -> NDArray[np.intp]:
    """Nodes in x = 0 that are of no face there."""
    cells = np.asarray(mesh.cells)
    on = np.asarray(mesh.points)[:, 0] == 0
    joined = np.zeros(len(on), dtype=bool)
    mids = {frozenset(ends): 4 + k for k, ends in enumerate(EDGES)}
    for face in _FACES:
        flat = on[cells[:, face]].all(axis=1)
        local = list(face)
        if cells.shape[1] == 10:
            local += [mids[frozenset((face[k], face[k - 1]))] for k in range(3)]
        joined[cells[flat][:, local]] = True
    return np.flatnonzero(on & ~joined)


def _text(place: NDArray[np.float64]) -> str:
    return f"({', '.join(f'{coordinate:.4g}' for coordinate in place)})"

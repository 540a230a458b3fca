"""A mesh whose nodes are moved, with sides as curved as its cells bear."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.scene.held import MeshArrays
from plica.scene.mesh.changed import changed_mesh
from plica.scene.symmetry import nearest_image
from plica.tetrahedron import EDGES, node_jacobians

__all__ = ["moved_mesh"]

Floats = NDArray[np.float64]

_LEAST = 0.1  # of det dx/dxi of the straight cell, as in the engine's larynx
_HALVINGS = 6  # of what sides are bent, then none


def moved_mesh(mesh: MeshArrays, to: Callable[[Floats], Floats]) -> _engine.TetMesh:
    """The mesh with its nodes where `to` has points (n, 3) m.

    Nodes in the middle of sides go there, too, as far as det dx/dxi of their cells stays above a tenth of
    that of straight ones; where it would not, their sides are less curved, straight at last, and so are those
    across the plane x = 0, about which the mesh is symmetric before: nodes of both folds stay partners.
    """
    points, cells = np.asarray(mesh.points), np.asarray(mesh.cells)
    goal = to(points)
    if cells.shape[1] == 4:
        return changed_mesh(mesh, points=goal)
    straight = goal.copy()
    for k, (i, j) in enumerate(EDGES):
        straight[cells[:, 4 + k]] = 0.5 * (goal[cells[:, i]] + goal[cells[:, j]])
    share, image = np.ones(len(points)), nearest_image(points, 0)
    moved = np.arange(len(cells))  # cells that are not as they were found to be
    for halving in range(_HALVINGS + 1):
        placed = straight + share[:, None] * (goal - straight)
        own = cells[moved]
        a, b, c, d = (placed[own[:, k]] for k in range(4))
        flat = np.linalg.det(np.stack((b - a, c - a, d - a), axis=1))
        bad = own[node_jacobians(placed, own).min(axis=1) < _LEAST * flat]
        if not len(bad):
            break
        less = np.unique(bad[:, 4:])
        less = np.union1d(less, image[less])
        share[less] *= 0.5 if halving + 1 < _HALVINGS else 0.0
        moved = np.flatnonzero(np.isin(cells[:, 4:], less).any(axis=1))
    return changed_mesh(mesh, points=placed)

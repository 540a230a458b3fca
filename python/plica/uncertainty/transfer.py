"""Transfer of nodal fields from one mesh to another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica.tetrahedron import shape_functions

__all__ = ["transferred"]

Floats = NDArray[np.float64]

_NEAR = 60  # nearest cells by their centres that are searched for a point
_BEYOND = 0.2  # of a cell: limit of extrapolation


def transferred(mesh: Any, fields: Sequence[Floats], points: Floats) -> list[Floats]:
    """Nodal fields (n, 3) of a mesh at points (k, 3), from the cell that each is in or nearest to.

    Cells are treated as straight when locating a point, and a point outside the mesh gets the field of the
    nearest cell, extrapolated by up to 0.2 of it: sufficient for an initial state, not for measures.
    """
    from scipy.spatial import cKDTree

    cells, nodes = np.asarray(mesh.cells), np.asarray(mesh.points)
    corners = nodes[cells[:, :4]]
    edges = np.linalg.inv((corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1))
    _, near = cKDTree(corners.mean(axis=1)).query(points, k=min(_NEAR, len(cells)))
    near = np.reshape(near, (len(points), -1))
    local = np.einsum("knij,knj->kni", edges[near], points[:, None] - corners[near, 0])
    weights = np.concatenate([1 - local.sum(axis=2, keepdims=True), local], axis=2)
    best = weights.min(axis=2).argmax(axis=1)
    rows = np.arange(len(points))
    chosen = np.clip(weights[rows, best], -_BEYOND, 1 + _BEYOND)
    shape = shape_functions(chosen) if cells.shape[1] == 10 else chosen
    return [np.einsum("ka,kai->ki", shape, field[cells[near[rows, best]]]) for field in fields]

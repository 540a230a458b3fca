"""Nodal fields of one mesh at the nodes of another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["SIDES", "shape_functions", "taken_over"]

Floats = NDArray[np.float64]

SIDES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
"""Corners of a tetrahedron's sides, in the order of a quadratic cell's nodes 4 to 9."""
_NEAR = 60  # cells by their centres, among which the one that holds a point is looked for
_BEYOND = 0.2  # of a cell: no further outside it is a field continued


def shape_functions(weights: Floats) -> Floats:
    """(k, 10) of the quadratic tetrahedron at barycentric coordinates (k, 4)."""
    corners = weights * (2 * weights - 1)
    return np.hstack([corners, *(4 * weights[:, [i]] * weights[:, [j]] for i, j in SIDES)])


def taken_over(mesh: Any, fields: Sequence[Floats], points: Floats) -> list[Floats]:
    """Nodal fields (n, 3) of a mesh at points (k, 3), by the cell that each is in or nearest to.

    Cells count as straight when a point is looked for, and a point outside the mesh takes the field of the
    nearest cell, continued by up to 0.2 of it: good to start from, not to measure.
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

"""Tetrahedra of a section that is extruded along y."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["extruded", "extruded_edges"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


def extruded(section: Floats, triangles: Integers, y: Floats) -> tuple[Floats, Integers]:
    """Points (n len(y), 3) and tetrahedra of a section (n, 2) in x and z; node i of level k has row k n + i.

    A prism is cut into three along the diagonals that rise from the lesser node of each edge of the section,
    on which neighbours agree.
    """
    n = len(section)
    points = np.concatenate([np.insert(section, 1, at, axis=1) for at in y])
    a, b, c = np.sort(triangles, axis=1).T
    cells = [
        np.stack(four, axis=1) + k * n
        for k in range(len(y) - 1)
        for four in ((a, b, c, c + n), (a, b, b + n, c + n), (a, a + n, b + n, c + n))
    ]
    return points, _upright(points, np.concatenate(cells))


def extruded_edges(edges: Integers, n: int, levels: int) -> Integers:
    """Triangles of edges (k, 2) of the section, on the diagonals of `extruded`."""
    a, b = np.sort(edges, axis=1).T
    faces = [
        np.stack(three, axis=1) + k * n
        for k in range(levels - 1)
        for three in ((a, b, b + n), (a, b + n, a + n))
    ]
    return np.concatenate(faces)


def _upright(points: Floats, cells: Integers) -> Integers:
    """The last two nodes exchanged where the volume is negative."""
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    inverted = np.linalg.det(edges) < 0
    cells[inverted] = cells[inverted][:, [0, 1, 3, 2]]
    return cells

"""Air between two surfaces that face each other along x."""

from __future__ import annotations

from typing import Any

import numpy as np

from plica import _engine as engine

__all__ = ["air_between"]


def air_between(points: np.ndarray, first: np.ndarray, second: np.ndarray) -> Any:
    """A tetrahedron of air for each node and the triangle that it lies over: it names them as candidates."""

    def cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])

    first, second = (engine.flat_triangles(np.asarray(faces)) for faces in (first, second))
    tets = []
    for surface, other in ((first, second), (second, first)):
        a, b, c = (points[surface[:, k], 1:] for k in range(3))
        for node in np.unique(other):
            to_node = points[node, 1:] - a
            area = cross(b - a, c - a)
            weights = np.stack([cross(to_node, c - a) / area, cross(b - a, to_node) / area])
            inside = np.minimum(weights.min(axis=0), 1 - weights.sum(axis=0))
            tets.append([*surface[np.argmax(inside)], node])
    return engine.Airway(first, second, np.array(tets, np.int32))

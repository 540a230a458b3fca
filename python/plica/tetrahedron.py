"""Node numbering of a tetrahedron in the engine: corners, then edge midpoints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["EDGES", "node_jacobians", "shape_functions"]

EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
"""The corners of each edge, in the order of the nodes 4 to 9."""


def shape_functions(weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 10) Shape functions of the quadratic tetrahedron at barycentric coordinates (k, 4)."""
    corners = weights * (2 * weights - 1)
    return np.hstack([corners, *(4 * weights[:, [i]] * weights[:, [j]] for i, j in EDGES)])


def node_jacobians(points: NDArray[np.float64], cells: NDArray[np.int32]) -> NDArray[np.float64]:
    """(m, 10) det dx/dxi (m^3) of quadratic tetrahedra (m, 10) at their nodes: 6 V with straight sides."""
    ends = np.array(EDGES)
    nodes = np.vstack([np.eye(4), 0.5 * (np.eye(4)[ends[:, 0]] + np.eye(4)[ends[:, 1]])])
    slopes = np.zeros((10, 10, 4))  # at each node, of each shape function, by each barycentric coordinate
    for corner in range(4):
        slopes[:, corner, corner] = 4 * nodes[:, corner] - 1
    for k, (i, j) in enumerate(EDGES):
        slopes[:, 4 + k, i], slopes[:, 4 + k, j] = 4 * nodes[:, j], 4 * nodes[:, i]
    local = slopes[..., 1:] - slopes[..., :1]
    return np.asarray(np.linalg.det(np.einsum("max,kal->mkxl", points[cells], local)))

"""Node numbering of a tetrahedron in the engine: corners, then edge midpoints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["EDGES", "shape_functions"]

EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
"""The corners of each edge, in the order of the nodes 4 to 9."""


def shape_functions(weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 10) Shape functions of the quadratic tetrahedron at barycentric coordinates (k, 4)."""
    corners = weights * (2 * weights - 1)
    return np.hstack([corners, *(4 * weights[:, [i]] * weights[:, [j]] for i, j in EDGES)])

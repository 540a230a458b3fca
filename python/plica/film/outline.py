"""Which pixels lie inside what a set of points spans."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["inside_hull"]


def inside_hull(points: NDArray[np.float64], shape: tuple[int, int]) -> NDArray[np.bool_]:
    """(h, w) pixels whose centres lie in the convex hull of points (n, 2), column and row in px."""
    from scipy.spatial import ConvexHull

    planes = ConvexHull(points).equations  # a x + b y + c <= 0 inside
    y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
    inside = np.ones(shape, dtype=bool)
    for a, b, c in planes:
        inside &= a * x + b * y + c <= 0
    return inside

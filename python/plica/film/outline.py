"""Which pixels lie inside what a set of points spans."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["inside_hull"]


def inside_hull(points: NDArray[np.float64], shape: tuple[int, int]) -> NDArray[np.bool_]:
    """(h, w) pixels whose centres lie in the convex hull of points (n, 2), column and row in px.

    Row by row between the sides of the hull: O(h sides + h w).
    """
    from scipy.spatial import ConvexHull

    a, b, c = ConvexHull(points).equations.T  # a x + b y + c <= 0 inside
    y = np.arange(shape[0])[:, None]
    level = b * y + c
    with np.errstate(divide="ignore", invalid="ignore"):
        end = -level / a
    right = np.where(a > 0, end, np.inf).min(axis=1)
    left = np.where(a < 0, end, -np.inf).max(axis=1)
    left[((a == 0) & (level > 0)).any(axis=1)] = np.inf  # above or below a level side
    x = np.arange(shape[1])
    return np.asarray((x >= left[:, None]) & (x <= right[:, None]))

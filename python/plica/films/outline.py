"""What a set of points spans."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plica._engine import within_hull

__all__ = ["Hull"]

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


class Hull:
    """The convex hull of points (n, 2), column and row in px."""

    def __init__(self, points: Floats) -> None:
        from scipy.spatial import ConvexHull

        self._sides: Floats = ConvexHull(points).equations  # a x + b y + c <= 0 inside

    def holds(self, places: Floats) -> Mask:
        """(p) whether places (p, 2) lie in it."""
        return within_hull(self._sides, places)

    def pixels(self, shape: tuple[int, int]) -> Mask:
        """(h, w) pixels whose centres lie in it, row by row between its sides."""
        a, b, c = self._sides.T
        level = b * np.arange(shape[0])[:, None] + c
        with np.errstate(divide="ignore", invalid="ignore"):
            end = -level / a
        right = np.where(a > 0, end, np.inf).min(axis=1)
        left = np.where(a < 0, end, -np.inf).max(axis=1)
        left[((a == 0) & (level > 0)).any(axis=1)] = np.inf  # above or below a level side
        x = np.arange(shape[1])
        return np.asarray((x >= left[:, None]) & (x <= right[:, None]))

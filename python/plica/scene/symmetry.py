"""Symmetric scenes: number of symmetry planes, and the symmetric part of a field."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["mirrored_mean", "nearest_image", "symmetry_planes"]


def symmetry_planes(symmetry: str | None) -> int:
    """Number of symmetry planes of a scene: 0, 1 (x = 0), or 2 (y = 0, too)."""
    return {None: 0, "half": 1, "quarter": 2}[symmetry]


def nearest_image(points: NDArray[np.float64], axis: int) -> NDArray[np.intp]:
    """The node (n) that each of symmetric points (n, 3) is mirrored to in the plane of this coordinate."""
    from scipy.spatial import cKDTree

    mirror = np.where(np.arange(3) == axis, -1.0, 1.0)
    found: NDArray[np.intp] = cKDTree(points).query(points * mirror)[1]
    return found


def mirrored_mean(
    fields: NDArray[np.floating[Any]], points: NDArray[np.float64], planes: int
) -> NDArray[np.float64]:
    """The part of nodal fields (..., n, 3) that is symmetric about x = 0 and, with two planes, y = 0.

    The points (n, 3) must be symmetric; the mirror image of a point is the point nearest to its image.
    """
    mean: NDArray[np.float64] = fields.astype(float)
    for axis in range(planes):
        mirror = np.where(np.arange(3) == axis, -1.0, 1.0)
        image = nearest_image(points, axis)
        mean = 0.5 * (mean + mirror * mean[..., image, :])
    return mean

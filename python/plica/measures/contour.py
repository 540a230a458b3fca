"""The folds' contour at rest in the mid-coronal plane, and the medial surface on it.

The medial surface is the range of heights around the narrowest place over which the contour is within 25
degrees of vertical (the catalogue says why); it ends at the inferior and the superior edge.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica.measures.record import Floats
from plica.measures.thresholds import medial_angle

__all__ = ["coronal_contours", "medial_surface", "narrowest_gap", "rest_contour"]

_SAME_HEIGHT = 1e-6  # of the surface's extent, as the engine's sections


def coronal_contours(
    points: Floats, faces: NDArray[np.integer[Any]], place: float | None = None
) -> tuple[Floats, Floats]:
    """The lines in which a plane of constant y cuts the folds, (k, 2) each of z and x (m), upward.

    Parameters
    ----------
    points : (n, 3) m
    faces : (f, 3 or 6) rows of `points`
        Of the airway, outward; by their corners.
    place : float, optional
        y (m) of the plane; default: halfway between their smallest and largest y.

    Returns
    -------
    tuple of arrays
        Of the fold at larger x, whose faces point to smaller x, and of the other; empty where it is not cut.
    """
    corners = np.asarray(faces)[:, :3]
    y = points[corners, 1]
    middle = 0.5 * (y.min() + y.max()) if place is None else place
    u, v = (points[corners[:, k]] - points[corners[:, 0]] for k in (1, 2))
    facing = np.sign(u[:, 1] * v[:, 2] - u[:, 2] * v[:, 1])
    lines = []
    for side in (-1.0, 1.0):
        own = corners[facing == side]
        edges = np.concatenate((own[:, [0, 1]], own[:, [1, 2]], own[:, [2, 0]]))
        y = points[edges, 1] - middle
        crossing = (y.min(axis=1) <= 0) & (y.max(axis=1) >= 0) & (np.ptp(y, axis=1) > 0)
        a, b, y = points[edges[crossing, 0]], points[edges[crossing, 1]], y[crossing]
        cut = a - (y[:, 0] / (y[:, 1] - y[:, 0]))[:, None] * (b - a)
        lines.append(cut[np.argsort(cut[:, 2])][:, [2, 0]])
    return lines[0], lines[1]


def rest_contour(points: Floats, faces: NDArray[np.integer[Any]], place: float | None = None) -> Floats:
    """Height z, smaller x and larger x (m) of the airway in a coronal plane, (k, 3), upward.

    At the vertices of the contours where both folds have one; `points`, `faces` and `place` as in
    `coronal_contours`. Empty where one of the folds is not cut.
    """
    larger, smaller = coronal_contours(points, faces, place)
    if not (len(larger) and len(smaller)):
        return np.empty((0, 3))
    low = max(float(line[0, 0]) for line in (larger, smaller))
    high = min(float(line[-1, 0]) for line in (larger, smaller))
    same = _SAME_HEIGHT * float(np.linalg.norm(np.ptp(points[np.unique(faces)], axis=0)))
    height = np.sort(np.concatenate((larger[:, 0], smaller[:, 0])))
    height = height[(height >= low) & (height <= high)]
    height = height[np.diff(height, prepend=-np.inf) > same]
    return np.column_stack(
        (height, *(np.interp(height, line[:, 0], line[:, 1]) for line in (smaller, larger)))
    )


def narrowest_gap(points: Floats, faces: NDArray[np.integer[Any]], place: float | None = None) -> float:
    """Least width (m) of the airway in a coronal plane, of `rest_contour`; not a number without it."""
    contour = rest_contour(points, faces, place)
    return float((contour[:, 2] - contour[:, 1]).min()) if len(contour) else float("nan")


def medial_surface(width: Floats, height: Floats) -> slice:
    """Range of heights that form the medial surface at rest (see the module docstring).

    Parameters
    ----------
    width : (s) m
        Of the airway at rest; half of it is the distance of the folds' contour from the midline.
    height : (s) m, ascending

    Returns
    -------
    slice
        A single height if the contour is nowhere so steep at the narrowest one.
    """
    steep = np.abs(np.diff(width)) <= 2.0 * np.tan(medial_angle) * np.diff(height)
    low = high = int(np.argmin(width))
    while low > 0 and steep[low - 1]:
        low -= 1
    while high + 1 < width.size and steep[high]:
        high += 1
    return slice(low, high + 1)

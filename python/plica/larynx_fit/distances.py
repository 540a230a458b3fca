"""Distances between outlines in a picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["ContourError", "contour_error", "to_outline"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ContourError:
    """Distances between two outlines, px, each measured from points of one to the other, both ways."""

    mean: float
    percentile_95: float
    largest: float


def to_outline(points: Floats, outline: Floats) -> Floats:
    """(n) distances of points (n, 2) from the closed polygon through `outline` (m, 2). O(n m)."""
    along = np.roll(outline, -1, axis=0) - outline
    squares = np.maximum((along**2).sum(axis=1), 1e-300)
    (a, b), (u, v) = outline.T, along.T
    nearest = np.full(len(points), np.inf)
    for part in np.array_split(np.arange(len(points)), len(points) // 500 + 1):
        x, y = points[part, :1] - a, points[part, 1:] - b
        share = np.clip((x * u + y * v) / squares, 0.0, 1.0)
        nearest[part] = np.sqrt(((x - share * u) ** 2 + (y - share * v) ** 2).min(axis=1))
    return nearest


def contour_error(contour: Floats, edge: Floats, spacing: float = 0.5) -> ContourError:
    """Distances of the contour (n, 2) px and an edge (m, 2) px, both closed, at points `spacing` px apart."""
    distances = np.concatenate(
        [to_outline(_even(contour, spacing), edge), to_outline(_even(edge, spacing), contour)]
    )
    return ContourError(float(distances.mean()), float(np.percentile(distances, 95)), float(distances.max()))


def _even(outline: Floats, spacing: float) -> Floats:
    """Equidistant points along a closed polygon."""
    closed = np.concatenate([outline, outline[:1]])
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    at = np.linspace(0, length[-1], max(8, int(length[-1] / spacing)), endpoint=False)
    return np.stack([np.interp(at, length, closed[:, k]) for k in range(2)], axis=1)

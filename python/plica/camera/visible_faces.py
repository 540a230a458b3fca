"""Intersections of lines of sight with the faces of a surface, flat or curved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica._engine import first_hits, hits_near

__all__ = ["Intersections", "lattice", "meet", "refined", "shapes"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Intersections:
    """The first intersection of each of p lines of sight.

    Attributes
    ----------
    face : (p) row of the faces, -1 where there is none
    place : (p, 2) coordinates (r, s) in it
    """

    face: Ints
    place: Floats


def lattice(divisions: int) -> Floats:
    """(p, 2) places (r, s) in a face, row by row: s = j / n, r = i / n, i + j <= n."""
    n = divisions
    return np.array([(i / n, j / n) for j in range(n + 1) for i in range(n + 1 - j)])


def shapes(nodes: int, place: Floats) -> Floats:
    """(p, nodes) shape functions of a face at (r, s): linear, or quadratic with middles of 12, 23, 31."""
    r, s = place.T
    t = 1 - r - s
    if nodes == 3:
        return np.column_stack([t, r, s])
    return np.column_stack(
        [t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t]
    )


def refined(
    nodes: Floats, faces: NDArray[Any], face: NDArray[Any], pixels: Floats, place: Floats
) -> tuple[Floats, Mask]:
    """Coordinates (p, 2) in faces at pixels, by Newton's iteration from `place` (p, 2).

    nodes and faces as in `meet`; face (p) the one of each of pixels (p, 2), column and row. Also (p) whether
    the iteration converged inside the face, on a side facing the camera.
    """
    hit, there = hits_near(nodes, faces, face, pixels, place)
    return there, hit >= 0


def meet(nodes: Floats, faces: NDArray[Any], pixels: Floats) -> Intersections:
    """The nearest face that each line of sight intersects from its outer side.

    Parameters
    ----------
    nodes : (n, 3)
        Column px, row px (down) and height towards the camera.
    faces : (f, 3) or (f, 6)
        Rows of nodes, anticlockwise seen from outside; six with the middles of the sides 12, 23, 31.
    pixels : (p, 2)
        Column and row; a line of sight with NaN has no intersection.

    Notes
    -----
    A curved face lies in the hull of its Bezier points, so that no intersected face is missed; within a face,
    Newton's iteration starts at fifteen points.
    """
    return Intersections(*first_hits(nodes, faces, pixels))

"""Where lines of sight meet the faces of a surface, flat or curved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Met", "lattice", "meet", "refined", "shapes"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

INSIDE = 1e-9
"""Of the coordinates in a face: no gap between neighbours."""
_CLOSE = 1e-9  # px, at which an iteration has met the pixel
_STEPS = 20  # of Newton's iteration, which doubles its digits in each
_LONGEST = 0.5  # of one of them, in coordinates of the face
_BEGINNINGS = 4  # divisions of a curved face's sides: a line of sight may meet it up to four times
_BATCH = 2_000_000  # pairs of a pixel and a face at a time


@dataclass(frozen=True)
class Met:
    """What each of p lines of sight meets first.

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


def slopes(nodes: int, place: Floats) -> tuple[Floats, Floats]:
    """(p, nodes) each: derivatives of `shapes` by r and by s."""
    r, s = place.T
    t, zero, one = 1 - r - s, np.zeros(len(r)), np.ones(len(r))
    if nodes == 3:
        return np.column_stack([-one, one, zero]), np.column_stack([-one, zero, one])
    by_r = [1 - 4 * t, 4 * r - 1, zero, 4 * (t - r), 4 * s, -4 * s]
    by_s = [1 - 4 * t, zero, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)]
    return np.column_stack(by_r), np.column_stack(by_s)


def refined(faces: Floats, pixels: Floats, place: Floats) -> tuple[Floats, Mask]:
    """Places (p, 2) at which faces (p, 3 or 6, 3), one a pixel, are seen, by Newton's iteration from `place`.

    Faces are nodes' column px, row px and height; pixels (p, 2) column and row. Also (p) whether the
    iteration has ended inside the face, on a side that looks at the camera.
    """
    flat, place = np.ascontiguousarray(faces[..., :2]), place.copy()
    found = np.zeros(len(pixels), dtype=bool)
    going = np.arange(len(pixels))
    for _ in range(_STEPS):
        at, own = place[going], flat[going]
        off = pixels[going] - np.einsum("pk,pkc->pc", shapes(flat.shape[1], at), own)
        a, b = (np.einsum("pk,pkc->pc", slope, own) for slope in slopes(flat.shape[1], at))
        area = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        close = np.abs(off).max(axis=1, initial=0.0) < _CLOSE
        inside = np.minimum(at.min(axis=1), 1 - at.sum(axis=1)) >= -INSIDE
        found[going[close]] = (inside & (area < 0))[close]  # rows count downwards
        safe = np.where(np.abs(area) > 1e-12, area, 1e-12)
        step = np.column_stack(
            [off[:, 0] * b[:, 1] - off[:, 1] * b[:, 0], a[:, 0] * off[:, 1] - a[:, 1] * off[:, 0]]
        )
        step /= safe[:, None]
        step *= np.minimum(1.0, _LONGEST / np.maximum(np.abs(step).max(axis=1), 1e-300))[:, None]
        keep = ~close
        going = going[keep]
        if not going.size:
            break
        place[going] += step[keep]
    return place, found


def meet(nodes: Floats, faces: NDArray[Any], pixels: Floats) -> Met:
    """The nearest face that each line of sight meets from its outer side.

    Parameters
    ----------
    nodes : (n, 3)
        Column px, row px (down) and height towards the camera.
    faces : (f, 3) or (f, 6)
        Rows of nodes, anticlockwise seen from outside; six with the middles of the sides 12, 23, 31.
    pixels : (p, 2)
        Column and row; a line of sight with a nan meets nothing.

    Notes
    -----
    A curved face lies in the hull of its Bezier points, so that no face that is met is left out; within a
    face, Newton's iteration begins at fifteen places.
    """
    kind = faces.shape[1]
    corners = nodes[faces]
    hull = corners[..., :2]
    if kind == 6:
        ends = hull[:, :3]
        hull = np.concatenate([ends, 2 * hull[:, 3:] - 0.5 * (ends + ends[:, [1, 2, 0]])], axis=1)
    low, high = hull.min(axis=1) - 1e-6, hull.max(axis=1) + 1e-6
    begin = np.array([[1 / 3, 1 / 3]]) if kind == 3 else lattice(_BEGINNINGS)
    face, place = np.full(len(pixels), -1, dtype=np.int64), np.zeros((len(pixels), 2))
    for part in np.array_split(np.arange(len(pixels)), max(1, len(pixels) * len(faces) // _BATCH)):
        at = pixels[part, None]
        pixel, own = np.nonzero(((at >= low) & (at <= high)).all(axis=2))
        pixel, own = (np.repeat(one, len(begin)) for one in (part[pixel], own))
        start = np.tile(begin, (len(own) // len(begin), 1))
        there, found = refined(corners[own], pixels[pixel], start)
        pixel, own, there = pixel[found], own[found], there[found]
        z = np.einsum("pk,pk->p", shapes(kind, there), corners[own, :, 2])
        order = np.argsort(z, kind="stable")  # of equal indices the last assignment stays: the nearest
        pixel, own, there = pixel[order], own[order], there[order]
        face[pixel], place[pixel] = own, there
    return Met(face, place)

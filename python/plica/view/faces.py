"""Intersections of lines of sight with the faces of a surface, flat or curved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Intersections", "lattice", "meet", "refined", "shapes"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

INSIDE = 1e-9
"""Tolerance of the coordinates in a face, so that there is no gap between neighbours."""
_CLOSE = 1e-9  # px, at which an iteration has converged
_STEPS = 20  # of Newton's iteration, which converges quadratically
_LONGEST = 0.5  # length of a step, in coordinates of the face
_START_DIVISIONS = 4  # divisions of a curved face's sides: a line of sight may intersect it up to four times
_BATCH = 2_000_000  # pairs of a pixel and a face at a time


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


def refined(faces: Floats, face: Ints, pixels: Floats, place: Floats) -> tuple[Floats, Mask]:
    """Coordinates (p, 2) in faces at pixels, by Newton's iteration from `place` (p, 2).

    faces (f, 3 or 6, 3) are nodes' column px, row px and height; face (p) the one of each of pixels (p, 2),
    column and row. Also (p) whether the iteration converged inside the face, on a side facing the camera.
    """
    terms, (x, y), (r, s) = _polynomial(faces[..., :2])[:, face], pixels.T, place.T
    solution, found = place.copy(), np.zeros(len(pixels), dtype=bool)
    active = np.arange(len(pixels))
    for _ in range(_STEPS):
        one_x, one_y, r_x, r_y, s_x, s_y, rr_x, rr_y, rs_x, rs_y, ss_x, ss_y = terms
        off_x = x - (one_x + r * (r_x + r * rr_x + s * rs_x) + s * (s_x + s * ss_x))
        off_y = y - (one_y + r * (r_y + r * rr_y + s * rs_y) + s * (s_y + s * ss_y))
        by_r = r_x + 2 * r * rr_x + s * rs_x, r_y + 2 * r * rr_y + s * rs_y
        by_s = s_x + 2 * s * ss_x + r * rs_x, s_y + 2 * s * ss_y + r * rs_y
        area = by_r[0] * by_s[1] - by_r[1] * by_s[0]
        close = np.maximum(np.abs(off_x), np.abs(off_y)) < _CLOSE
        inside = np.minimum(np.minimum(r, s), 1 - r - s) >= -INSIDE
        done = active[close]
        solution[done, 0], solution[done, 1] = r[close], s[close]
        found[done] = (inside & (area < 0))[close]  # rows count downwards
        active = active[~close]
        if not active.size:
            break
        area = np.where(np.abs(area) > 1e-12, area, 1e-12)
        step_r = (off_x * by_s[1] - off_y * by_s[0]) / area
        step_s = (by_r[0] * off_y - by_r[1] * off_x) / area
        short = np.minimum(1.0, _LONGEST / np.maximum(np.maximum(np.abs(step_r), np.abs(step_s)), 1e-300))
        r, s = r + short * step_r, s + short * step_s
        if close.any():
            terms, x, y, r, s = terms[:, ~close], x[~close], y[~close], r[~close], s[~close]
    return solution, found


def _polynomial(flat: Floats) -> Floats:
    """(12, f) column and row as 1, r, s, r^2, r s, s^2 of faces (f, 3 or 6, 2)."""
    a, b, c = flat[:, 0], flat[:, 1], flat[:, 2]
    if flat.shape[1] == 3:
        terms = [a, b - a, c - a, 0 * a, 0 * a, 0 * a]
    else:
        ab, bc, ca = flat[:, 3], flat[:, 4], flat[:, 5]
        by_r, by_s = 4 * ab - 3 * a - b, 4 * ca - 3 * a - c
        terms = [a, by_r, by_s, 2 * (a + b) - 4 * ab, 4 * (a + bc - ab - ca), 2 * (a + c) - 4 * ca]
    return np.ascontiguousarray(np.concatenate([term.T for term in terms]))


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
    kind = faces.shape[1]
    corners = nodes[faces]
    hull = corners[..., :2]
    if kind == 6:
        ends = hull[:, :3]
        hull = np.concatenate([ends, 2 * hull[:, 3:] - 0.5 * (ends + ends[:, [1, 2, 0]])], axis=1)
    low, high = hull.min(axis=1) - 1e-6, hull.max(axis=1) + 1e-6
    begin = np.array([[1 / 3, 1 / 3]]) if kind == 3 else lattice(_START_DIVISIONS)
    face, place = np.full(len(pixels), -1, dtype=np.int64), np.zeros((len(pixels), 2))
    for part in np.array_split(np.arange(len(pixels)), max(1, len(pixels) * len(faces) // _BATCH)):
        at = pixels[part, None]
        pixel, own = np.nonzero(((at >= low) & (at <= high)).all(axis=2))
        pixel, own = (np.repeat(one, len(begin)) for one in (part[pixel], own))
        start = np.tile(begin, (len(own) // len(begin), 1))
        there, found = refined(corners, own, pixels[pixel], start)
        pixel, own, there = pixel[found], own[found], there[found]
        z = np.einsum("pk,pk->p", shapes(kind, there), corners[own, :, 2])
        order = np.argsort(z, kind="stable")  # of equal indices the last assignment stays: the nearest
        pixel, own, there = pixel[order], own[order], there[order]
        face[pixel], place[pixel] = own, there
    return Intersections(face, place)

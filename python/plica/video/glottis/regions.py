"""Regions of a frame, grown and filled; only in the box of rows and columns that they lie in."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["bounds", "filled", "grown"]

Mask = npt.NDArray[np.bool_]


def bounds(mask: Mask, beyond: int = 0) -> tuple[slice, slice]:
    """Rows and columns of what is true in a mask (h, w) and so many pixels `beyond`; none where none is."""

    def part(axis: int) -> slice:
        there = np.flatnonzero(mask.any(axis=axis))
        return slice(max(int(there[0]) - beyond, 0), int(there[-1]) + 1 + beyond) if there.size else slice(0)

    return part(1), part(0)


def grown(mask: Mask, by: int) -> Mask:
    """The mask (h, w), and what is at most so many steps along rows and columns from it."""
    found = mask.copy()
    part = found[bounds(mask, by)]
    for _ in range(by):
        before = part.copy()
        part[1:] |= before[:-1]
        part[:-1] |= before[1:]
        part[:, 1:] |= before[:, :-1]
        part[:, :-1] |= before[:, 1:]
    return found


def filled(mask: Mask) -> Mask:
    """The mask (h, w) without holes: what no way along rows and columns leads out of is in it."""
    from scipy import ndimage

    around = np.ones((mask.shape[0] + 2, mask.shape[1] + 2), dtype=bool)
    around[1:-1, 1:-1] = ~mask
    labels, _ = ndimage.label(around)
    return np.asarray(labels != labels[0, 0])[1:-1, 1:-1]

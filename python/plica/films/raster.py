"""The triangle shown by each pixel, with a depth buffer; the height of the triangles at any position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plica._engine import heights_above, interpolated, rasterise_triangles

__all__ = ["Raster", "highest", "rasterise"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True)
class Raster:
    """What the pixels' centres show.

    Attributes
    ----------
    triangle : (h, w) row of the triangles, -1 where there is none
    pixels : (p) flat positions of the pixels that show one
    shown : (p) its triangle
    share : (p, 3) barycentric coordinates in it
    """

    triangle: Ints
    pixels: NDArray[np.intp]
    shown: Ints
    share: Floats

    def of(self, values: Floats, triangles: Ints) -> Floats:
        """(p, c) values (v, c) at the triangles' corners, interpolated to the pixels."""
        return interpolated(self.share, triangles[self.shown], values)


def rasterise(corners: Floats, triangles: Ints, within: NDArray[np.bool_]) -> Raster:
    """The nearest triangle at each pixel's centre among those that face the camera.

    Parameters
    ----------
    corners : (v, 3)
        Column px, row px (down), height towards the camera.
    triangles : (t, 3)
        Anticlockwise seen from outside; triangles seen from the back are not rendered.
    within : (h, w)
        Pixels that may show one.
    """
    triangle, share = rasterise_triangles(corners, triangles, within)
    pixels = np.flatnonzero(triangle >= 0)
    return Raster(triangle, pixels, triangle.ravel()[pixels], share)


def highest(places: Floats, corners: Floats, triangles: Ints, shape: tuple[int, int]) -> Floats:
    """(p) greatest height of the triangles facing the camera at positions (p, 2) px; -inf: none.

    Other parameters as in `rasterise`. Each position is tested with the triangles that meet its unit square.
    """
    return heights_above(places, corners, triangles, *shape)

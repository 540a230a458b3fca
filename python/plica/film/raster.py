"""Which triangle a pixel shows: rasterising with a depth buffer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Raster", "rasterise"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_BATCH = 2_000_000  # pairs of a triangle and a pixel at a time
_EDGE = 1e-9  # of barycentric coordinates: no gap between neighbours


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
    pixels: Ints
    shown: Ints
    share: Floats

    def of(self, values: Floats, triangles: Ints) -> Floats:
        """(p, ...) what the pixels show of values (v, ...) at the triangles' corners."""
        corners = values[triangles[self.shown]]
        return np.asarray(np.einsum("pk,pk...->p...", self.share, corners))


def rasterise(corners: Floats, triangles: Ints, shape: tuple[int, int]) -> Raster:
    """The nearest triangle at each pixel's centre among those that face the camera.

    Parameters
    ----------
    corners : (v, 3)
        Column px, row px (down), height towards the camera.
    triangles : (t, 3)
        Anticlockwise seen from outside; others show their back and are not drawn.
    shape : (height, width) px

    Notes
    -----
    O(sum of the triangles' bounding boxes + pixels): 20 thousand triangles on 256 x 256 px take 40 ms.
    """
    height, width = shape
    p = corners[triangles]
    low = np.ceil(p[..., :2].min(axis=1) - 1e-9).astype(np.int64)
    high = np.floor(p[..., :2].max(axis=1) + 1e-9).astype(np.int64)
    low, high = np.maximum(low, 0), np.minimum(high, [width - 1, height - 1])
    size = high - low + 1
    planes, area = _planes(p)
    # Rows count downwards, so what is anticlockwise seen from outside has a negative area in px.
    drawn = np.flatnonzero((size > 0).all(axis=1) & (area < -1e-12))
    nearest = np.full(height * width, -np.inf)
    owner = np.full(height * width, -1, dtype=np.int64)
    pairs = np.cumsum(size[drawn].prod(axis=1))
    batch = np.searchsorted(pairs, np.arange(1, (pairs[-1] if pairs.size else 0) // _BATCH + 2) * _BATCH)
    for part in np.split(drawn, np.unique(batch[batch < drawn.size])):
        _draw(part, low, size, planes, width, nearest, owner)
    pixels = np.flatnonzero(owner >= 0)
    shown = owner[pixels]
    x, y = (pixels % width).astype(float), (pixels // width).astype(float)
    share = np.stack([_at(planes[shown, k], x, y) for k in range(3)], axis=1)
    return Raster(owner.reshape(shape), pixels, shown, share)


def _planes(p: Floats) -> tuple[Floats, Floats]:
    """(t, 4, 3) barycentric coordinates and height, each as a + b x + c y; (t) twice the area."""
    x, y, z = p[..., 0], p[..., 1], p[..., 2]
    planes = np.zeros((len(p), 4, 3))
    area = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
    safe = np.where(area == 0, 1.0, area)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        planes[:, k, 0] = (x[:, i] * y[:, j] - x[:, j] * y[:, i]) / safe
        planes[:, k, 1] = (y[:, i] - y[:, j]) / safe
        planes[:, k, 2] = (x[:, j] - x[:, i]) / safe
    planes[:, 3] = np.einsum("tk,tkc->tc", z, planes[:, :3])
    return planes, area


def _at(plane: Floats, x: Floats, y: Floats) -> Floats:
    return np.asarray(plane[:, 0] + plane[:, 1] * x + plane[:, 2] * y)


def _draw(
    part: Ints, low: Ints, size: Ints, planes: Floats, width: int, nearest: Floats, owner: NDArray[Any]
) -> None:
    """Enter these triangles into the buffers."""
    count = size[part].prod(axis=1)
    own = np.repeat(part, count)
    local = np.arange(own.size) - np.repeat(np.cumsum(count) - count, count)
    column = low[own, 0] + local % size[own, 0]
    row = low[own, 1] + local // size[own, 0]
    x, y = column.astype(float), row.astype(float)
    inside = np.ones(own.size, dtype=bool)
    for k in range(3):
        inside &= _at(planes[own, k], x, y) >= -_EDGE
    own, x, y, pixel = own[inside], x[inside], y[inside], (row * width + column)[inside]
    height = _at(planes[own, 3], x, y)
    order = np.argsort(height, kind="stable")  # of equal indices the last assignment stays: the nearest
    order = order[height[order] > nearest[pixel[order]]]
    nearest[pixel[order]] = height[order]
    owner[pixel[order]] = own[order]

"""Whether cells of two bodies overlap."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from plica.tetrahedron import EDGES

__all__ = ["find_overlap"]

_Reals = NDArray[np.float64]
_Integers = NDArray[np.int32]

_LEAST = 1e-3  # of the size of a cell
_PAIRS = 20_000  # at once
_FACES = ((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2))


def find_overlap(x: _Reals, cells: _Integers, body: _Integers) -> tuple[float, int, int] | None:
    """Depth (m) of the first cells of two bodies that overlap, and these cells; None if there are none.

    Parameters
    ----------
    x : (n, 3) m
    cells : (m, 4)
    body : (m)
        Number of each cell's body.

    Notes
    -----
    Two convex cells are apart if and only if they are so along the normal of one of their faces or along the
    product of an edge of each (separating axes); the depth is the least of the overlaps along them. The cells
    are looked at in pairs whose boxes overlap: O(cells log cells + pairs).
    """
    corners = x[cells]
    low, high = corners.min(axis=1), corners.max(axis=1)
    near = np.flatnonzero(_in_another(low, high, body))
    for one, other in _pairs(low, high, body, near):
        depth, size = _depths(corners[one], corners[other])
        deep = depth - _LEAST * size
        if len(deep) and deep.max() > 0:
            k = int(deep.argmax())
            return float(depth[k]), int(one[k]), int(other[k])
    return None


def _in_another(low: _Reals, high: _Reals, body: _Integers) -> NDArray[np.bool_]:
    """(m) whether a cell's box overlaps the box of another body; with many bodies, all."""
    numbers = np.unique(body)
    if len(numbers) > 20:
        return np.ones(len(body), dtype=bool)
    near = np.zeros(len(body), dtype=bool)
    for number in numbers:
        own = body == number
        near |= ~own & (low < high[own].max(axis=0)).all(axis=1) & (high > low[own].min(axis=0)).all(axis=1)
    return near


def _pairs(
    low: _Reals, high: _Reals, body: _Integers, near: NDArray[np.intp]
) -> Iterator[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Cells (k) and (k) of different bodies whose boxes overlap, among `near`; a sweep along their longest
    extent."""
    if not len(near):
        return
    axis = int(np.ptp(low[near], axis=0).argmax())
    order = near[np.argsort(low[near, axis], kind="stable")]
    ends = np.searchsorted(low[order, axis], high[order, axis], side="left")
    counts = np.maximum(ends - np.arange(len(order)) - 1, 0)
    start = 0
    while start < len(order):
        stop = max(start + 1, int(np.searchsorted(np.cumsum(counts[start:]), 50 * _PAIRS)) + start)
        own = np.repeat(np.arange(start, stop), counts[start:stop])
        first = np.repeat(np.cumsum(counts[start:stop]) - counts[start:stop], counts[start:stop])
        one, other = order[own], order[own + 1 + np.arange(len(own)) - first]
        kept = body[one] != body[other]
        one, other = one[kept], other[kept]
        kept = ((low[one] < high[other]) & (low[other] < high[one])).all(axis=1)
        one, other = one[kept], other[kept]
        for k in range(0, len(one), _PAIRS):
            yield one[k : k + _PAIRS], other[k : k + _PAIRS]
        start = stop


def _depths(one: _Reals, other: _Reals) -> tuple[_Reals, _Reals]:
    """How deep cells (k, 4, 3) and (k, 4, 3) m are in each other, (k), negative where they are apart; and the
    mean edge of the smaller one."""
    edges = [np.stack([cell[:, b] - cell[:, a] for a, b in EDGES], axis=1) for cell in (one, other)]
    axes = [
        np.stack([np.cross(cell[:, b] - cell[:, a], cell[:, c] - cell[:, a]) for a, b, c in _FACES], axis=1)
        for cell in (one, other)
    ]
    axes.append(np.cross(edges[0][:, :, None], edges[1][:, None]).reshape(len(one), -1, 3))
    axis = np.concatenate(axes, axis=1)
    lengths = np.linalg.norm(edges[0], axis=2).mean(axis=1), np.linalg.norm(edges[1], axis=2).mean(axis=1)
    size = np.minimum(*lengths)
    norm = np.linalg.norm(axis, axis=2)
    parallel = norm <= 1e-9 * (size**2)[:, None]  # edges: no axis of its own
    unit = axis / np.where(parallel, 1.0, norm)[:, :, None]
    spans = [np.einsum("kcd,kad->kac", cell - one[:, :1], unit) for cell in (one, other)]
    overlap = np.minimum(
        spans[0].max(axis=2) - spans[1].min(axis=2), spans[1].max(axis=2) - spans[0].min(axis=2)
    )
    return np.where(parallel, np.inf, overlap).min(axis=1), size

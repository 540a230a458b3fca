"""Trajectories of points that follow the flow, and the correlation length of the flow's error."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from plica.errors import InvalidInput
from plica.identify.observation.sources import PixelMotion

__all__ = ["correlation_length", "follow_points"]

Floats = NDArray[np.float64]

_CORRELATION_LIMIT = 0.2  # largest correlation of the flow's error between points
_FARTHEST = 40  # px, largest distance that is examined


def follow_points(
    motion: PixelMotion, pairs: Iterable[int], start: Floats, progress: bool = False
) -> tuple[Floats, Floats, Floats]:
    """Trajectories (N + 1, r, 2) px of points (r, 2), their flow (N, r, 2), nan where it is not reliable, and
    its error (N, r) px, nan where unknown. Bilinear interpolation between pixels."""
    chosen = list(pairs)
    paths, flows, errors = [start], [], []
    height, width = motion.shape
    for pair in _with_progress(chosen, progress):
        at = paths[-1]
        field = motion.flow(pair)
        if field.shape != (height, width, 2):
            raise InvalidInput(
                f"identify: the flow of pair {pair} has shape {field.shape}; must be ({height}, {width}, 2)."
            )
        move = np.stack([_sampled(field[..., c], at) for c in (0, 1)], axis=1)
        seen = _nearest(motion.visible(pair), at, False)
        flows.append(np.where(seen[:, None], move, np.nan))
        errors.append(np.where(seen, _error(motion, pair, at), np.nan))
        there = at + move
        there[~((there >= 0) & (there <= [width - 1, height - 1])).all(axis=1)] = np.nan
        paths.append(there)
    return np.array(paths), np.array(flows), np.array(errors)


def correlation_length(fields: Iterable[Floats], farthest: int = _FARTHEST) -> float | None:
    """Distance (px) at which the correlation of fields (h, w), nan where unknown, along rows and columns
    falls below 0.2; `farthest` if it does not; None without values."""
    products, squares = np.zeros(farthest + 1), np.zeros(farthest + 1)
    for field in fields:
        values = field - np.nanmean(field) if np.isfinite(field).any() else field
        for axis in (0, 1):
            along = np.moveaxis(values, axis, 0)
            for lag in range(min(farthest, len(along) - 1) + 1):
                a, b = along[lag:], along[: len(along) - lag]
                both = np.isfinite(a) & np.isfinite(b)
                products[lag] += float(np.sum(a[both] * b[both]))
                squares[lag] += 0.5 * float(np.sum(a[both] ** 2 + b[both] ** 2))
    if not squares[0] > 0:
        return None
    share = np.divide(products, squares, out=np.zeros_like(products), where=squares > 0)
    below = np.flatnonzero(share < _CORRELATION_LIMIT)
    return float(below[0]) if len(below) else float(farthest)


def _error(motion: PixelMotion, pair: int, at: Floats) -> Floats:
    if motion.sd is not None:
        stated = np.asarray(_nearest(motion.sd(pair), at, np.nan))
        wrong = np.flatnonzero((stated <= 0) | np.isinf(stated))
        if len(wrong):
            column, row = at[wrong[0]].round()
            raise InvalidInput(
                f"{motion.name}: sd[{pair}, {row:g}, {column:g}] = {stated[wrong[0]]:g} px; must be > 0 and "
                "finite, or nan where unknown. Take what is useless as not visible."
            )
        return stated
    if motion.error is None:
        return np.full(len(at), np.nan)
    round_trip = np.hypot(*np.moveaxis(motion.error(pair), -1, 0))  # of two flows, two components
    return np.asarray(_nearest(round_trip / np.sqrt(2), at, np.nan))


def _sampled(field: NDArray[Any], at: Floats) -> Floats:
    found = np.full(len(at), np.nan)
    inside = np.isfinite(at[:, 0])
    found[inside] = ndimage.map_coordinates(
        field.astype(float), [at[inside, 1], at[inside, 0]], order=1, mode="nearest"
    )
    return found


def _nearest(field: NDArray[Any], at: Floats, outside: Any) -> Any:
    """The values of the pixels that contain the points."""
    found = np.full(len(at), outside, dtype=field.dtype)
    inside = np.isfinite(at[:, 0])
    rows, columns = np.round(at[inside, ::-1]).astype(int).T
    found[inside] = field[rows, columns]
    return found


def _with_progress(pairs: list[int], shown: bool) -> Iterator[int]:
    if not shown:
        yield from pairs
        return
    from tqdm import tqdm

    interval = 0.5 if sys.stderr.isatty() else 10.0
    yield from tqdm(pairs, desc="reading", unit=" frames", mininterval=interval, file=sys.stderr)

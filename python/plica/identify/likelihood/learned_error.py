"""Estimate the error of a flow from residuals: size by point, correlation in time and space, outliers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from plica.identify.likelihood.flow_error import FlowError

__all__ = ["learned"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

ORDER = 2  # of the autoregression in time
NEIGHBOURS = 3  # on which a point is conditioned
OUTLYING = 5.0  # robust sd beyond which a value is treated as missing
_LEAST_SD = 0.3  # of the median sd
_SHRINK = 30.0  # prior weight of size 1, as a number of values
_UNIT_SIZE = 0.2  # |log| of a frame's size that is set to 1
_FEW = 10  # values below which a point gets the median sd


def learned(residual: Array, seen: Mask, motion: Array, image: Array) -> FlowError:
    """The error from residuals (N, r, 2) px where `seen` (N, r, 2), the model's motion (N, r, 2) px and the
    positions of the points (r, 2) px."""
    values = np.where(seen, residual, np.nan)
    points = values.shape[1]
    counts = np.isfinite(values).sum(axis=(0, 2))
    robust = np.full(points, np.nan)
    for p in np.flatnonzero(counts >= _FEW):
        robust[p] = np.nanmedian(np.abs(values[:, p])) / 0.6745
    robust = _floored(robust)
    outliers = np.any(np.abs(values) > OUTLYING * robust[:, None], axis=2)  # nan: no
    values[outliers] = np.nan
    sd = np.full(points, np.nan)
    for p in np.flatnonzero(counts >= _FEW):
        sd[p] = np.sqrt(np.nanmean(values[:, p] ** 2))
    sd = _floored(sd)
    scores = values / sd[:, None]
    phi = _autoregression(scores)
    innovations = scores.copy()
    for lag, factor in enumerate(phi, start=1):
        innovations[lag:] -= factor * scores[:-lag]
        innovations[:lag] = np.nan
    by_frame = _by_frame(innovations)
    innovations /= by_frame[:, None, None]
    distances = np.hypot(*np.moveaxis(image[:, None] - image, -1, 0))
    share, length = _decay(innovations, distances)
    before = _before(distances)
    return FlowError(sd, by_frame, phi, share, length, before, distances, motion, outliers)


def _floored(sd: Array) -> Array:
    middle = float(np.nanmedian(sd)) if np.isfinite(sd).any() else 1.0
    return np.maximum(np.where(np.isfinite(sd), sd, middle), _LEAST_SD * middle)


def _by_frame(scores: Array) -> Array:
    """(N) rms of a frame's scores over that of all, shrunk towards 1 as if 30 scores of 1 were among them; 1
    if it is within a fifth of that, since frames of equal size keep T' W T cheap."""
    whole = np.nanmean(scores**2)
    counts = np.isfinite(scores).sum(axis=(1, 2))
    if not np.isfinite(whole) or whole <= 0:
        return np.ones(len(scores))
    squares = np.nansum(scores**2, axis=(1, 2)) / whole
    size: Array = np.sqrt((squares + _SHRINK) / (counts + _SHRINK))
    return np.where(np.abs(np.log(size)) < _UNIT_SIZE, 1.0, size)


def _autoregression(scores: Array) -> Array:
    """(2) Yule-Walker estimate from all points and both components."""
    lags = [np.nanmean(scores[lag:] * scores[: len(scores) - lag]) for lag in range(ORDER + 1)]
    if len(scores) <= 3 * ORDER or not np.isfinite(lags).all():
        return np.zeros(ORDER)
    phi: Array = linalg.solve_toeplitz(lags[:-1], lags[1:])
    return phi


def _decay(scores: Array, distances: Array) -> tuple[float, float]:
    """share and length of share exp(-d / length), by least squares over all pairs."""
    points = len(distances)
    if points < 3:
        return 0.0, 1.0
    known = np.isfinite(scores)
    filled = np.where(known, scores, 0.0)
    products = np.einsum("tpc,tqc->pq", filled, filled)
    counts = np.einsum("tpc,tqc->pq", known.astype(float), known.astype(float))
    upper = np.triu_indices(points, 1)
    d, n = distances[upper], counts[upper]
    mean = products[upper] / np.maximum(n, 1) / max(float(np.nanmean(scores**2)), 1e-300)
    best = (0.0, 0.0, float(d[d > 0].min(initial=np.inf)))
    nearest = best[2]
    if not np.isfinite(nearest):
        return 0.0, 1.0
    for length in nearest * np.geomspace(0.3, 10, 24):
        shape = np.exp(-d / length)
        share = float(np.clip(np.sum(n * mean * shape) / np.sum(n * shape**2), 0, 0.98))
        gain = float(np.sum(n * (mean**2 - (mean - share * shape) ** 2)))
        if gain > best[0]:
            best = (gain, share, float(length))
    return best[1], best[2]


def _before(distances: Array) -> NDArray[np.intp]:
    """(r, 3) the nearest points of smaller index, -1 if there are fewer."""
    found = np.full((len(distances), NEIGHBOURS), -1, dtype=np.intp)
    for p in range(1, len(distances)):
        nearest = np.argsort(distances[p, :p], kind="stable")[:NEIGHBOURS]
        found[p, : len(nearest)] = nearest
    return found

"""Error model of an optical flow: correlated, different at each point, in part proportional to the motion.

The error of point p in frame k is e = B_p (T w + mu) + v. B_p (2, 2) is a gain of the point's own, with
independent entries N(0, sigma_g^2): regularised flow mixes a point's motion with that of its surroundings.
v is Gaussian with the covariance K_time x (s_p s_p' rho(|x_p - x_p'|)) of each component: autoregressive in
time with innovations of a size of each frame, and in space a share that decays with the distance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse

__all__ = ["FlowError", "Whitening"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class FlowError:
    """The error of r points over N frames."""

    sd: Array
    """(r) px, up to a common factor that is estimated with the tissue"""
    by_frame: Array
    """(N) factor on the size of the innovations"""
    in_time: Array
    """(a) phi: v_k = sum_l phi[l] v_{k-1-l} + innovation"""
    share: float
    """[-] in [0, 1): correlation of two points at distance zero"""
    length: float
    """[px] over which it decays by a factor e"""
    neighbours: NDArray[np.intp]
    """(r, j) earlier points on which each point is conditioned; -1: none"""
    distances: Array
    """(r, r) px in the image"""
    motion: Array
    """(N, r, 2) px a frame to which gains apply: the model's motion when the error was learned"""
    outliers: Mask
    """(N, r) values treated as missing"""

    def of_first(self, frames: int) -> FlowError:
        """The error of the first frames alone."""
        parts = {name: getattr(self, name)[:frames] for name in ("by_frame", "motion", "outliers")}
        return replace(self, **parts)


class Whitening:
    """Combinations of observed rows that have independent errors.

    From each value its expectation given the previous frames and its neighbours in the same frame is
    subtracted (A. V. Vecchia, J. R. Stat. Soc. B 50, 1988), as far as these are observed. Using the same
    combination of lags keeps T block-Toeplitz; where other neighbours are observed, the combination is
    another row. A value whose own past is not observed is left out. The transformation has determinant one.

    Attributes
    ----------
    weights : (N, m') 1/px^2; zero where a row does not apply to a frame
    source : (m') index among the observed rows (2 r) of each
    """

    def __init__(self, error: FlowError, weights: Array) -> None:
        frames, m = weights.shape
        seen = (weights > 0) & ~np.repeat(error.outliers, 2, axis=1)
        self._phi = error.in_time
        there = seen.copy()
        for lag in range(1, len(self._phi) + 1):
            there[lag:] &= seen[:-lag]
            there[:lag] = False
        rows: list[int] = []
        columns: list[int] = []
        values: list[float] = []
        source: list[int] = []
        frame_weights: list[Array] = []
        for j in range(m):
            p, c = divmod(j, 2)
            near = error.neighbours[p][error.neighbours[p] >= 0]
            known = there[:, 2 * near + c] & there[:, [j]]
            for pattern in np.unique(known[there[:, j]], axis=0):
                used = near[pattern]
                factors, variance = _conditioned(error, p, used)
                row = len(source)
                rows += [row] * (1 + len(used))
                columns += [j, *(2 * used + c)]
                values += [1.0, *(-factors)]
                source.append(j)
                frame_weights.append(
                    np.where(
                        there[:, j] & (known == pattern).all(axis=1), 1 / (variance * error.by_frame**2), 0.0
                    )
                )
        self._mix = sparse.csr_array((values, (rows, columns)), shape=(len(source), m))
        self.source = np.array(source, dtype=int)
        self.weights = np.ascontiguousarray(np.array(frame_weights).T.reshape(frames, len(source)))

    def __call__(self, values: Array, axis: int = 0) -> Array:
        """Of values (..., N, m, ...) with frames along `axis` and rows along the next."""
        moved = np.moveaxis(values, (axis, axis + 1), (0, 1))
        filtered = _filtered(moved, self._phi)
        flat = np.moveaxis(filtered, 1, 0).reshape(filtered.shape[1], -1)
        mixed = (self._mix @ flat).reshape(-1, filtered.shape[0], *filtered.shape[2:])
        return np.ascontiguousarray(np.moveaxis(np.moveaxis(mixed, 1, 0), (0, 1), (axis, axis + 1)))

    def gains(self, motion: Array) -> sparse.csc_array:
        """(N m', 4 r) Response of the rows to the gains xx, xy, yx, yy of points with motion (N, r, 2)."""
        filtered = _filtered(motion, self._phi)
        mix = self._mix.tocoo()
        frames, width = self.weights.shape
        rows, columns, values = [], [], []
        for row, j, share in zip(mix.row, mix.col, mix.data, strict=True):
            shown = np.flatnonzero(self.weights[:, row] > 0)
            for d in (0, 1):
                rows.append(shown * width + row)
                columns.append(np.full(len(shown), 2 * j + d))
                values.append(share * filtered[shown, j // 2, d])
        shape = (frames * width, 4 * motion.shape[1])
        if not rows:  # no point is seen for as long as the error's lags
            return sparse.csc_array(shape)
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return sparse.coo_array(entries, shape=shape).tocsc()

    def unfolded(self, values: Array, rows: int) -> Array:
        """(N, m) values of the observed rows from (N, m') of these; nan where a value has no row."""
        out = np.full((len(values), rows), np.nan)
        for row, j in enumerate(self.source):
            shown = self.weights[:, row] > 0
            out[shown, j] = values[shown, row]
        return out


def _filtered(values: Array, phi: Array) -> Array:
    """Innovations of an autoregression along the first axis."""
    filtered = values.copy()
    for lag, factor in enumerate(phi, start=1):
        filtered[lag:] -= factor * values[:-lag]
    return filtered


def _conditioned(error: FlowError, point: int, used: NDArray[np.intp]) -> tuple[Array, float]:
    """Factors of the neighbours in the expectation of a point's error, and its conditional variance
    (px^2)."""
    own = float(error.sd[point])
    if not len(used):
        return np.zeros(0), own**2

    def correlation(distance: Array) -> Array:
        near: Array = error.share * np.exp(-distance / error.length)
        return near

    K = correlation(error.distances[np.ix_(used, used)])
    np.fill_diagonal(K, 1.0)
    k = correlation(error.distances[used, point])
    factors = linalg.solve(K, k, assume_a="pos")
    return factors * own / error.sd[used], own**2 * (1 - float(k @ factors))
